"""The sensor at fault is named by what all sensors read; records are drawn from a model that is true."""

import dataclasses
import math

import numpy as np
import pytest
from heave_node.numerics.linear_model import covariance_factor
from heave_node.parameters import build_parameters
from winch_controller_node.design.design import design_controller
from winch_controller_node.estimation.reading_record import RECORD, ReadingRecord, Surprise
from winch_controller_node.identification.suspicions import suspect
from winch_controller_node.model.estimator import Innovation, Measurement, RecordedTick
from winch_controller_node.node_parameters import WinchControllerParameters

DT = 0.05
BELIEF = {"length": 900.0, "cable_model.inertia": 7.34, "cable_model.damping": 0.19}


def parameters(**values):
    return build_parameters(WinchControllerParameters, BELIEF | values, where="test")


def design_for(wanted, factors=(1.0, 1.0)):
    cable = design_controller(wanted, tick_period=DT).cable
    cable = dataclasses.replace(cable, a=factors[0] * cable.a, b=factors[1] * cable.b)
    return design_controller(wanted, tick_period=DT, cable=cable)


def record_of(truth, *, turned_over=(), scale=1.0, mean=0.0):
    """Return a minute of readings of the model `truth`, winch locked.

    What is `turned_over` has the wrong sign; what the MRU reads is `scale` times the truth, and its heave has a `mean`.
    """
    design, random = design_for(truth), np.random.default_rng(3)
    model = design.model
    factor = covariance_factor(model.noise_covariance)
    x = np.linalg.cholesky(design.initial_covariance + 1e-12 * np.eye(model.order)) @ random.standard_normal(
        model.order
    )
    x[[model.state(name) for name in model.state_names if name.startswith("payout") or name.endswith("bias")]] = 0.0
    record = ReadingRecord(DT)
    for tick in range(round(RECORD / DT)):
        readings = [
            Measurement(
                known.name,
                float(
                    (-1.0 if known.name in turned_over else 1.0)
                    * (scale if known.sensor == "mru" else 1.0)
                    * known.row
                    @ x
                    + (mean if known.name == "mru_heave" else 0.0)
                    + known.sigma * random.standard_normal()
                ),
                tick,
            )
            for known in design.measurements
        ]
        record.add(RecordedTick(tick, 0.0, tuple(readings)))
        x = model.A @ x + factor @ random.standard_normal(factor.shape[1])
        x[[model.state(name) for name in model.state_names if name.startswith("payout")]] = 0.0
    return record.ticks()


@pytest.mark.long
def test_sensors_that_are_as_believed_are_not_suspected():
    belief = parameters()
    verdict = suspect(belief, record_of(belief), design_for, DT)
    assert verdict.suspicion.culprit == ""


@pytest.mark.parametrize("period", [27.0, pytest.param(50.0, marks=pytest.mark.long)])
def test_a_high_pass_that_nobody_told_of_is_found_with_its_corner(period):
    verdict = suspect(parameters(), record_of(parameters(**{"sensors.mru.high_pass_period": period})), design_for, DT)
    assert verdict.suspicion.culprit == "mru"
    assert "high-pass" in verdict.suspicion.words
    found = verdict.suspicion.parameters.sensors.mru.high_pass_period
    # what is left of the corner's error turns the heave at 10 s by less than 2 degrees
    assert found == pytest.approx(period, rel=0.06)
    assert verdict.estimator.model.has_state("mru_offset")


@pytest.mark.parametrize("scale", [0.75, pytest.param(1.25, marks=pytest.mark.long)])
def test_a_scale_of_the_mru_is_found_and_told(scale):
    verdict = suspect(parameters(), record_of(parameters(), scale=scale), design_for, DT)
    assert verdict.suspicion.culprit == "mru or drum"
    # an extended Kalman filter finds most of it in a minute, and the rest while it goes on
    error = verdict.estimator.estimate[verdict.estimator.model.state("mru_scale")]
    assert f" {1.0 + error:.2f} times " in verdict.suspicion.words
    assert error == pytest.approx(scale - 1.0, rel=0.3)


@pytest.mark.parametrize("learns_swell", [False, True])
def test_a_mean_of_the_heave_is_found_and_told_also_where_it_was_taken_for_a_swell(learns_swell):
    belief = parameters()
    seen = parameters(**{"sea.peak_period": 30.0}) if learns_swell else belief
    verdict = suspect(seen, record_of(belief, mean=-0.4), design_for, DT, first_sea=belief.sea)
    assert verdict.suspicion.findings == {"mru": "its heave has a mean of -0.40 m, which is taken off"}
    assert verdict.suspicion.parameters.sea == belief.sea


@pytest.mark.parametrize(
    ("inertia", "damping"), [(1.25, 3.0), pytest.param(1.2, 1.0, marks=pytest.mark.long)], ids=["both", "inertia"]
)
def test_a_cable_other_than_believed_is_no_fault_of_a_sensor(inertia, damping):
    belief = parameters()
    cable = {"cable_model.inertia": inertia * BELIEF["cable_model.inertia"]}
    cable["cable_model.damping"] = damping * BELIEF["cable_model.damping"]
    verdict = suspect(belief, record_of(parameters(**cable)), design_for, DT)
    assert verdict.suspicion.culprit == "cable"
    assert verdict.design.cable.a == pytest.approx(cable["cable_model.inertia"], rel=0.06)
    # a minute tells damping to a factor of one and a half
    assert 1.0 / 1.5 < verdict.design.cable.b / cable["cable_model.damping"] < 1.5


def test_a_high_pass_on_a_cable_of_other_inertia_is_found_with_it():
    """Either of them alone explained too little, and the MRU was doubted as a whole."""
    truth = parameters(
        **{"sensors.mru.high_pass_period": 27.0, "cable_model.inertia": 1.3 * BELIEF["cable_model.inertia"]}
    )
    verdict = suspect(parameters(), record_of(truth), design_for, DT)
    assert list(verdict.suspicion.findings) == ["mru", "cable"]
    assert verdict.suspicion.parameters.sensors.mru.high_pass_period == pytest.approx(27.0, rel=0.06)
    assert verdict.design.cable.a == pytest.approx(1.3 * BELIEF["cable_model.inertia"], rel=0.03)
    assert verdict.suspicion.findings["mru"].startswith("its heave has a high-pass with a cut-off period of 2")
    assert verdict.suspicion.findings["cable"].startswith("it answers with 1.")


@pytest.mark.parametrize(
    ("turned_over", "sensor"),
    [(("mru_heave", "mru_heave_rate"), "mru"), pytest.param(("unit_heave",), "depth", marks=pytest.mark.long)],
)
def test_the_load_cell_witnesses_which_of_two_sensors_has_the_wrong_sign(turned_over, sensor):
    """Without it nobody could say whether MRU or depth sensor is upside down."""
    truth = parameters(**{"sensors.use": ["mru", "depth", "encoder", "load_cell"]})
    verdict = suspect(parameters(), record_of(truth, turned_over=turned_over), design_for, DT)
    assert verdict.suspicion.culprit == verdict.suspicion.doubted == sensor


@pytest.mark.parametrize(
    ("height", "doubted"),
    [(1.8, ""), (0.01, "depth"), (1.8, "depth")],
    ids=["a sea, none doubted", "at rest", "a sea"],
)
def test_a_sensor_that_is_doubted_is_trusted_once_there_is_something_that_it_tells(height, doubted):
    """A unit at rest shows no sign: one that has been turned over reads there what it should."""
    belief = parameters(**{"sea.significant_wave_height": height})
    verdict = suspect(belief, record_of(belief), design_for, DT, doubted=doubted)
    assert verdict.suspicion.doubted == ("depth" if height < 0.1 else "")
    assert verdict.suspicion.culprit == verdict.suspicion.doubted


def test_surprise_lasts_while_innovations_are_larger_than_foreseen_and_can_be_excused():
    surprise = Surprise(DT)
    for _ in range(600):
        surprise.add({"unit_heave": Innovation(0.02, 0.02, 1.0, True)})
    assert (surprise.time, surprise.words) == (0.0, "")
    for _ in range(600):
        surprise.add({"unit_heave": Innovation(0.06, 0.02, 9.0, True), "payout": Innovation(1.0, 1e-3, 1e6, True)})
    assert surprise.worst[0] == "unit_heave"
    # 1 + 8 (1 - exp(-t/20 s)) is above 2 from 2.7 s on
    assert surprise.time == pytest.approx(30.0 + 20.0 * math.log(7.0 / 8.0), abs=0.2)
    assert "unit_heave is 2.7 times as far off as foreseen" in surprise.words
    # a mean square of 7.2 falls to 2, with a memory of 20 s, when 1 comes from now on
    assert f"about {20.0 * math.log(surprise.worst[1] - 1.0):.0f} s while it settles" in surprise.words
    waited = 0
    while surprise.words and not waited > 1000:
        surprise.add({"unit_heave": Innovation(0.02, 0.02, 1.0, True)})
        waited += 1
    assert waited * DT == pytest.approx(20.0 * math.log(6.2), rel=0.02)
    for _ in range(600):
        surprise.add({"unit_heave": Innovation(0.06, 0.02, 9.0, True)})
    words = surprise.unexplained("depth")
    assert "no sensor or cable explains it" in words
    assert words.endswith("where it comes again look at sensor depth and at what hangs on the cable")
    surprise.excuse()
    assert surprise.words == ""
    surprise.restart()
    assert (surprise.time, surprise.is_excused) == (0.0, False)


def test_a_record_knows_how_far_back_it_reaches():
    record = ReadingRecord(DT)
    for number in range(5, 20):
        record.add(RecordedTick(number, 0.0, ()))
    assert [tick.number for tick in record.ticks(16)] == [17, 18, 19]
    assert record.reaches_to(5) and not record.reaches_to(4) and not record.covers(RECORD)
    record.clear()
    assert not record.reaches_to(5)
