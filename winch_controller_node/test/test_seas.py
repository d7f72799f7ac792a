"""The sea that predicts the readings best is assumed; records are drawn from a model that is true."""

import dataclasses
import math

import numpy as np
import pytest
from heave_node.parameters import build_parameters
from winch_controller_node.adviser.record import SensorHistory
from winch_controller_node.adviser.sea import SENSORS, likeliest_sea
from winch_controller_node.design.design import design_controller
from winch_controller_node.design.feasibility import boom_tip_moments
from winch_controller_node.design.seas import (
    LIKELY,
    SeaSeen,
    neighbours,
    no_lower_while_it_grows,
    possible_seas,
    sigma_and_frequency,
)
from winch_controller_node.node_parameters import WinchControllerParameters

DT = 0.05
DEEP = {"length": 900.0, "cable_model.inertia": 7.34, "cable_model.damping": 0.19}
WIND_SEA = {"sea.significant_wave_height": 1.5, "sea.peak_period": 10.0}
TWO_PARTS = {
    "sea.spectrum": "ochi_hubble",
    "sea.shape": 1.0,
    "sea.significant_wave_height": 1.5,
    "sea.peak_period": 8.0,
    "sea.filter_states": 10,
    "sea.swell.significant_wave_height": 1.0,
    "sea.swell.peak_period": 16.5,
    "sea.swell.shape": 3.0,
}


def parameters(*values):
    wanted = {name: value for part in (DEEP, {"sensors.use": list(SENSORS)}, *values) for name, value in part.items()}
    return build_parameters(WinchControllerParameters, wanted, where="test")


def design_of(wanted):
    return design_controller(wanted, tick_period=DT)


def seen_of(truth):
    """Return what is seen of the boom tip in the sea of `truth` after very many waves."""
    heave, frequency = sigma_and_frequency(truth.sea, truth.vessel)
    return SeaSeen(waves=1e4, heave=heave, frequency=frequency)


@pytest.fixture
def found(drawn_from):
    """Return a function that returns the sea that is found in a record drawn from the `truth`, the winch locked."""

    def search(belief, truth, seconds=110.0, seed=5, seas=None):
        seas = seas or possible_seas(seen_of(truth), belief.sea, belief.sea, belief.vessel)
        record = drawn_from(design_of(truth), seconds, seed=seed, size=0.0)
        return likeliest_sea(belief, design_of(belief), seas, record, SensorHistory())

    return search


@pytest.mark.parametrize("seed", range(4))
def test_a_sea_as_believed_is_kept(found, seed):
    """Two minutes are some ten waves: by chance of another period, which is no other sea."""
    belief = parameters(WIND_SEA)
    assert found(belief, belief, seed=seed) is None


@pytest.mark.parametrize("period", [6.0, 8.0, 13.0])
def test_a_sea_of_another_period_is_found(found, period):
    belief, truth = parameters(WIND_SEA), parameters(WIND_SEA, {"sea.peak_period": period})
    sea = found(belief, truth)
    # neighbours are a tenth apart, and one that is nearer to the belief is preferred where both predict it as well
    assert sea.peak_period == pytest.approx(period, rel=0.1)
    assert sea.significant_wave_height == pytest.approx(1.5, rel=0.1)


def test_a_sea_that_is_more_regular_than_any_model_is_not_taken_for_a_longer_one(excerpt_of):
    """Regular waves of 12 s: the longer the assumed sea, the better it predicts them; their period is seen."""
    belief = parameters({"sea.significant_wave_height": 3.4, "sea.peak_period": 12.0})
    omega, amplitude, random = 2.0 * math.pi / 12.0, 4.0, np.random.default_rng(2)
    sigmas = {known.name: known.sigma for known in design_of(belief).measurements}
    readings, count = [], round(110.0 / DT)
    for tick in range(count):
        phase = omega * tick * DT
        heave, rate = amplitude * math.sin(phase), amplitude * omega * math.cos(phase)
        truth = {"mru_heave": heave, "mru_heave_rate": rate, "payout": 0.0}
        for name, sigma in sigmas.items():
            readings.append({"tick": tick, "row": name, "value": truth[name] + sigma * random.standard_normal()})
    record = excerpt_of(count, readings, tuple(sigmas))
    seen = SeaSeen(waves=9.0, heave=amplitude / math.sqrt(2.0), frequency=omega)
    sea = belief.sea
    for _ in range(4):
        seas = possible_seas(seen, belief.sea, sea, belief.vessel)
        in_force = dataclasses.replace(belief, sea=sea)
        sea = likeliest_sea(in_force, design_of(in_force), seas, record, SensorHistory()) or sea
    frequency = sigma_and_frequency(sea, belief.vessel)[1]
    assert frequency > omega * math.exp(-LIKELY / math.sqrt(seen.waves))


@pytest.mark.slow
def test_a_shorter_wind_sea_beside_the_swell_that_was_believed_leaves_the_swell_where_it_is(found):
    """One factor for both would put the swell at half its period, where no state of the model follows the true one."""
    belief = parameters(TWO_PARTS)
    truth = parameters(TWO_PARTS, {"sea.significant_wave_height": 2.0, "sea.peak_period": 6.0})
    sea = found(belief, truth)
    assert sea.peak_period == pytest.approx(6.0, rel=0.1)
    assert sea.swell.peak_period == 16.5
    assert 0.5 < sea.swell.significant_wave_height < 1.6


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_parts_are_compared_where_the_mean_frequency_tells_nothing_new(found, seed):
    """While it grew, a longer wind sea was taken for a higher swell, which has the same mean frequency.

    It is longer by half, which costs FARTHER log(1.5) + WORTH = 34 nats. Two minutes hold some 50 where the two parts
    stand apart, as here: of a flatter wind sea, or a lower one, they hold fewer than that now and then.
    """
    apart = {"sea.shape": 3.0}
    belief = parameters(TWO_PARTS, apart)
    truth = parameters(TWO_PARTS, apart, {"sea.significant_wave_height": 7.0, "sea.peak_period": 12.0})
    in_force = parameters(TWO_PARTS, apart, {"sea.swell.significant_wave_height": 2.49})
    seas = possible_seas(seen_of(truth), belief.sea, in_force.sea, belief.vessel)
    assert seas.stretched is None
    frequencies = [sigma_and_frequency(one.sea, belief.vessel)[1] for one in (truth, in_force)]
    assert frequencies[0] == pytest.approx(frequencies[1], rel=0.01)
    sea = found(in_force, truth, seed=seed, seas=seas)
    assert sea.peak_period == pytest.approx(12.0, rel=0.1)
    assert sea.significant_wave_height == pytest.approx(7.0, rel=0.1)
    assert sea.swell.significant_wave_height < 1.6


def test_a_short_record_tells_nothing_and_the_moments_decide(found):
    belief, truth = parameters(WIND_SEA), parameters(WIND_SEA, {"sea.peak_period": 6.0})
    assert found(belief, truth, seconds=20.0).peak_period == pytest.approx(6.0, rel=1e-2)
    assert found(belief, belief, seconds=20.0) is None


@pytest.mark.parametrize(
    "part",
    [
        {"sea.significant_wave_height": 2.5, "sea.peak_period": 6.0},
        {"sea.swell.significant_wave_height": 2.0, "sea.swell.peak_period": 13.0},
    ],
    ids=["wind sea", "swell"],
)
def test_the_part_of_a_sea_that_has_changed_is_told_by_the_moments_where_the_other_is_as_believed(part):
    """Moments add up over the parts of a spectrum."""
    belief, truth = parameters(TWO_PARTS), parameters(TWO_PARTS, part)
    candidates = possible_seas(seen_of(truth), belief.sea, belief.sea, belief.vessel).parts

    def distance(sea):
        return abs(sea.peak_period - truth.sea.peak_period) + abs(sea.swell.peak_period - truth.sea.swell.peak_period)

    near = min(candidates, key=distance)
    assert near.peak_period == pytest.approx(truth.sea.peak_period, rel=0.01)
    assert near.swell.peak_period == pytest.approx(truth.sea.swell.peak_period, rel=0.01)
    assert near.significant_wave_height == pytest.approx(truth.sea.significant_wave_height, rel=0.01)
    assert near.swell.significant_wave_height == pytest.approx(truth.sea.swell.significant_wave_height, rel=0.01)


def test_all_seas_that_are_compared_move_the_boom_tip_as_was_seen():
    belief = parameters(TWO_PARTS)
    truth = parameters(TWO_PARTS, {"sea.significant_wave_height": 3.0, "sea.peak_period": 11.0})
    seen = seen_of(truth)
    seas = possible_seas(seen, belief.sea, belief.sea, belief.vessel)
    near = neighbours(belief.sea, 1.2, seen, belief.vessel)
    for sea in (seas.in_force, *seas.others, *near):
        assert math.sqrt(boom_tip_moments(sea, belief.vessel)[0]) == pytest.approx(seen.heave, rel=1e-3)


def test_a_sea_that_may_still_grow_is_not_believed_to_be_lower():
    belief = parameters(WIND_SEA)
    low = dataclasses.replace(seen_of(belief), heave=0.1 * seen_of(belief).heave, is_settled=False)
    seas = possible_seas(low, belief.sea, belief.sea, belief.vessel)
    grown = no_lower_while_it_grows(seas.in_force, seas)
    assert grown.significant_wave_height == pytest.approx(1.5)
    settled = dataclasses.replace(seas, seen=dataclasses.replace(low, is_settled=True))
    assert no_lower_while_it_grows(seas.in_force, settled).significant_wave_height < 0.2
