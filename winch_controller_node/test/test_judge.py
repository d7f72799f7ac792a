"""The sensor, or the cable, that differs from what is assumed; records are drawn from a model that is true."""

import dataclasses
import math

import numpy as np
import pytest
from heave_node.parameters import build_parameters
from hypothesis import given
from hypothesis import strategies as st
from winch_controller_node.adviser.filter_pass import pass_model
from winch_controller_node.adviser.hypothesis import (
    ACCEPTED,
    AGAIN,
    CLEARLY,
    EXCLUSION,
    PRICES,
    TELLING,
    Assumed,
    Change,
    Hypothesis,
    accepted,
    rules_out_encoder,
)
from winch_controller_node.adviser.judge import Judge
from winch_controller_node.adviser.record import SensorHistory
from winch_controller_node.beliefs.beliefs import Correction
from winch_controller_node.beliefs.quantities import QUANTITIES
from winch_controller_node.design.design import design_controller
from winch_controller_node.node_parameters import WinchControllerParameters

DT = 0.05
DEEP = {
    "length": 900.0,
    "cable_model.inertia": 7.34,
    "cable_model.damping": 0.19,
    "sea.significant_wave_height": 2.5,
    "sea.peak_period": 12.0,
}
TICKS = 1200


def parameters(**values):
    named = {name.replace("__", "."): value for name, value in values.items()}
    return build_parameters(WinchControllerParameters, DEEP | named, where="test")


def designed(wanted=None, *, inertia=1.0):
    wanted = parameters() if wanted is None else wanted
    plain = design_controller(wanted, tick_period=DT)
    cable = dataclasses.replace(plain.cable, a=inertia * plain.cable.a)
    return design_controller(wanted, tick_period=DT, cable=cable) if inertia != 1.0 else plain


@pytest.fixture(scope="module")
def belief():
    return designed()


def assumed(design, **other):
    known = {"values": {}, "history": SensorHistory()} | other
    return Assumed(design.parameters, design.parameters, design.cable, design, **known)


def found_in(excerpt, design, **other):
    """Return what is accepted of a record at a second look, and the best of each culprit."""
    judge = Judge(excerpt, assumed(design, **other))
    ranked = judge.best()
    return accepted(ranked, judge.present, ranked[0], judge.used), ranked, judge


def scaled(sensor, factor, since=0, offset=0.0):
    """Return what makes of readings of a sensor `factor` times as much from a tick on, of heave with an `offset`."""
    rows = {"mru": ("mru_heave", "mru_heave_rate"), "depth": ("unit_heave",), "encoder": ("payout",)}[sensor]

    def change(name, value, tick):
        if name not in rows or tick < since:
            return value
        return factor * value + (offset if name == "mru_heave" else 0.0)

    return change


@pytest.mark.parametrize("seed", range(6))
def test_sensors_and_cable_that_are_as_believed_are_not_blamed(belief, drawn_from, seed):
    found, _, judge = found_in(drawn_from(belief, seed=seed), belief)
    assert found is None
    # mean squares of 1 of half a minute, correlated over some tenths of a second
    assert judge.present.worst(judge.used) < 1.5


@pytest.mark.parametrize(
    ("quantity", "factor", "since"),
    [
        ("mru.scale", 0.75, 0),
        ("mru.scale", 1.25, 0),
        ("mru.scale", -1.0, 800),
        ("mru.scale", 2.0, 900),
        ("depth.scale", -1.0, 0),
        ("depth.scale", 1.5, 700),
    ],
)
def test_a_wrong_scale_is_found_with_its_sensor_and_its_size(belief, drawn_from, quantity, factor, since):
    record = drawn_from(belief, change=scaled(QUANTITIES[quantity].owner, factor, since))
    found, *_ = found_in(record, belief)
    assert list(found.changes) == [quantity]
    change = found.changes[quantity]
    assert change.value == pytest.approx(factor, abs=max(4.0 * change.sigma, 0.02))
    # the first onsets that are tried lie up to 9 s apart
    assert change.since == pytest.approx(since, abs=2.5 / DT)
    assert found.excluded == ""


@pytest.mark.parametrize("offset", [-0.4, 0.25])
def test_a_mean_of_the_heave_is_found(belief, drawn_from, offset):
    found, *_ = found_in(drawn_from(belief, change=scaled("mru", 1.0, offset=offset)), belief)
    assert list(found.changes) == ["mru.offset"]
    assert found.changes["mru.offset"].value == pytest.approx(offset, abs=0.04)


@pytest.mark.parametrize("ticks", [3, 5])
def test_an_mru_that_is_late_is_found(belief, drawn_from, ticks):
    late = {}

    def change(name, value, tick):
        if not name.startswith("mru"):
            return value
        late[name, tick] = value
        return late.get((name, tick - ticks))

    found, *_ = found_in(drawn_from(belief, change=change), belief)
    assert list(found.changes) == ["mru.delay"]
    # made up for by a slope: (omega d)^2 / 2 of the motion is left
    assert found.changes["mru.delay"].value == pytest.approx(ticks * DT, abs=0.02)


@pytest.mark.parametrize("period", [27.0, 50.0])
def test_a_high_pass_that_nobody_told_of_is_found_with_its_corner(belief, drawn_from, period):
    truth = designed(parameters(sensors__mru__high_pass_period=period))
    found, *_ = found_in(drawn_from(truth), belief)
    assert list(found.changes) == ["mru.high_pass_period"]
    # what is left of the corner's error turns the heave at 10 s by less than 2 degrees
    assert found.changes["mru.high_pass_period"].value == pytest.approx(period, rel=0.08)
    assert "mru_offset" in found.state_names


@pytest.mark.parametrize(("inertia", "seed"), [(0.8, 4), (1.25, 5)])
def test_a_cable_of_other_inertia_is_no_fault_of_a_sensor(belief, drawn_from, inertia, seed):
    found, *_ = found_in(drawn_from(designed(inertia=inertia), seed=seed), belief)
    assert list(found.changes) == ["cable.inertia_factor"]
    assert found.changes["cable.inertia_factor"].value == pytest.approx(inertia, rel=0.05)


def test_a_heave_that_wanders_is_tracked(belief, drawn_from):
    """A random walk of 1.5 cm in a second, heave alone: its rate is that of the motion."""
    walk = np.cumsum(0.015 * math.sqrt(DT) * np.random.default_rng(4).standard_normal(TICKS))
    record = drawn_from(belief, change=lambda name, value, tick: value + (walk[tick] if name == "mru_heave" else 0.0))
    found, ranked, _ = found_in(record, belief)
    best = found or ranked[0]
    assert best.culprits == {"mru"}
    assert "mru.bias_drift" in best.changes or "mru.high_pass_period" in best.changes


@pytest.mark.parametrize("sensor", ["mru", "depth"])
def test_a_sensor_that_tells_of_another_sea_has_no_scale_and_is_no_other_cable(belief, drawn_from, sensor):
    """Divided by eight it would be as good as none: of what was read that explains nothing."""
    rows = {"mru": ("mru_heave", "mru_heave_rate"), "depth": ("unit_heave",)}[sensor]
    other = drawn_from(belief, seed=77)
    read = {(int(one[1]), other.rows[int(one[2])]): one[3] for one in other.readings}
    record = drawn_from(belief, change=lambda name, value, tick: read[tick, name] if name in rows else value)
    found, *_ = found_in(record, belief)
    assert found is None or found.excluded == sensor


def test_a_sensor_that_was_left_out_is_used_again_once_it_tells_the_truth(belief, drawn_from):
    found, _, judge = found_in(drawn_from(belief), belief, excluded="depth")
    assert judge.present.excluded == "depth"
    assert found is not None
    assert found.excluded == ""


def test_what_is_believed_already_is_not_found_again(belief, drawn_from):
    record = drawn_from(belief, change=scaled("mru", 1.25))
    history = SensorHistory((("mru", 0, Correction(scale=1.25)),))
    found, *_ = found_in(record, belief, values={"mru.scale": 1.25}, history=history)
    assert found is None


def test_a_belief_that_is_wrong_by_now_goes_back_to_nominal(belief, drawn_from):
    history = SensorHistory((("mru", 0, Correction(scale=1.25)),))
    found, *_ = found_in(drawn_from(belief), belief, values={"mru.scale": 1.25}, history=history)
    assert found.changes["mru.scale"].value == 1.0


def test_the_encoder_is_ruled_out_where_the_sensors_agree_with_it(belief, drawn_from):
    """A winch of half the gain moves the unit by what the encoder reads."""
    _, ranked, _ = found_in(drawn_from(belief), belief, drum_gain=1.0)
    assert rules_out_encoder(ranked)


def test_the_encoder_is_not_ruled_out_where_it_reads_half_of_what_all_others_show(belief, drawn_from):
    record = drawn_from(belief, size=0.6, change=scaled("encoder", 0.5))
    _, ranked, _ = found_in(record, belief, drum_gain=0.5)
    assert ranked[0].changes["encoder.scale"].value == pytest.approx(0.5, rel=0.05)
    assert not rules_out_encoder(ranked)


def test_the_state_goes_on_from_where_the_truth_is(belief, drawn_from):
    """Of an MRU of three quarters the boom tip is known, under what is found, as without the fault."""
    row = belief.model.row("boom_tip_heave")
    right = Judge(drawn_from(belief), assumed(belief)).present
    found, *_ = found_in(drawn_from(belief, change=scaled("mru", 0.75)), belief)
    assert row @ found.state == pytest.approx(row @ right.state, abs=0.03)
    assert np.min(np.linalg.eigvalsh(found.covariance)) > -1e-9


def test_the_start_is_as_uncertain_as_in_the_design_but_for_what_may_be_anywhere(belief):
    model, sampled = pass_model(belief.parameters, belief.cable, belief)
    assert sampled.state_names == belief.model.state_names
    waves = [belief.model.state(name) for name in belief.sea_states]
    np.testing.assert_allclose(model.start[np.ix_(waves, waves)], belief.initial_covariance[np.ix_(waves, waves)])
    assert model.start[belief.model.state("payout"), belief.model.state("payout")] >= 100.0


# prices and the rule


def hypothesis(total, changes=(), excluded="", worst=1.0):
    held = {name: Change(2.0, 0.1, 0) for name in changes}
    return Hypothesis(held, excluded, total, 0.0, {"mru_heave": worst}, np.zeros(1), np.eye(1), ("a",))


PRESENT = hypothesis(100.0, worst=9.0)


@pytest.mark.parametrize(
    ("best", "other", "before", "is_accepted"),
    [
        (100.0 - ACCEPTED, None, False, True),
        (100.0 - ACCEPTED + 0.1, None, False, False),
        (100.0 - AGAIN, None, True, True),
        (100.0 - AGAIN + 0.1, None, True, False),
        (40.0, 40.0 + CLEARLY, False, True),
        (40.0, 40.0 + CLEARLY - 0.1, False, False),
    ],
)
def test_one_rule_accepts(best, other, before, is_accepted):
    one = hypothesis(best, ["mru.scale"])
    ranked = [one] + ([] if other is None else [hypothesis(other, ["depth.scale"])]) + [PRESENT]
    found = accepted(ranked, PRESENT, one if before else None, ["mru_heave"])
    assert (found is one) is is_accepted
    assert found in (one, None)


def test_what_leaves_the_record_unexplained_is_not_accepted():
    """Of a mean square of 9 a quarter is 2.25: up to 4 may be left."""
    assert accepted([hypothesis(0.0, ["mru.scale"], worst=4.1), PRESENT], PRESENT, None, ["mru_heave"]) is None
    one = hypothesis(0.0, ["mru.scale"], worst=3.9)
    assert accepted([one, PRESENT], PRESENT, None, ["mru_heave"]) is one
    far = hypothesis(100.0, worst=400.0)
    one = hypothesis(0.0, ["mru.scale"], worst=99.0)
    assert accepted([one, far], far, None, ["mru_heave"]) is one


def test_two_culprits_at_once_leave_nothing_for_a_third():
    """A drum of another radius in a landing: mass and MRU were blamed with a mean square of 29, of 182 before."""
    far, names = hypothesis(1e3, worst=400.0), ["mru_heave"]
    for worst, is_accepted in ((4.1, False), (3.9, True)):
        both = hypothesis(0.0, ["mru.scale", "cable.inertia_factor"], worst=worst)
        assert (accepted([both, far], far, None, names) is both) is is_accepted


def test_damping_is_identified_only_where_it_leaves_nothing_to_explain():
    """What moves otherwise than predicted, for whatever reason, is predicted better by less motion."""
    for worst, is_accepted in ((1.9, False), (1.7, True)):
        one = hypothesis(0.0, ["cable.damping_factor"], worst=worst)
        assert (accepted([one, PRESENT], PRESENT, None, ["mru_heave"]) is one) is is_accepted


def test_what_explains_one_sensor_and_makes_another_worse_is_not_accepted():
    """An offset of the MRU explained a depth after a stop, and left its own readings further from their prediction."""
    present = dataclasses.replace(PRESENT, misfits={"mru_heave": 1.0, "unit_heave": 9.0})
    for own, is_accepted in ((1.3, False), (1.1, True)):
        one = dataclasses.replace(hypothesis(0.0, ["mru.offset"]), misfits={"mru_heave": own, "unit_heave": 1.0})
        assert (accepted([one, present], present, None, list(present.misfits)) is one) is is_accepted


def test_one_culprit_more_is_no_other_explanation_and_is_not_taken_where_it_explains_no_more():
    one, both = hypothesis(40.0, ["mru.scale"]), hypothesis(40.1, ["mru.scale", "cable.inertia_factor"])
    assert accepted([one, both, PRESENT], PRESENT, None, ["mru_heave"]) is one
    both = dataclasses.replace(both, loss=40.0 - 0.9 * CLEARLY)
    assert accepted([both, one, PRESENT], PRESENT, None, ["mru_heave"]) is one
    both = dataclasses.replace(both, loss=40.0 - 1.1 * CLEARLY)
    assert accepted([both, one, PRESENT], PRESENT, None, ["mru_heave"]) is None, "two at once need twice the evidence"
    far = dataclasses.replace(PRESENT, loss=both.loss + 2.0 * ACCEPTED)
    assert accepted([both, one, far], far, None, ["mru_heave"]) is both


@pytest.mark.parametrize(
    ("quantity", "value", "witness", "is_accepted"),
    [
        ("mru.scale", 0.7, 9.0, True),
        ("mru.scale", 0.7, 1.1, False),
        ("mru.scale", 1.4, 1.1, True),
        ("depth.scale", 0.7, 9.0, False),
    ],
)
def test_a_correction_that_makes_orders_larger_needs_another_sensor_that_says_so(quantity, value, witness, is_accepted):
    """The depth sensor is `witness` times its noise off under the present beliefs, mean square."""
    present = dataclasses.replace(PRESENT, misfits={"mru_heave": 1.0, "unit_heave": witness})
    one = dataclasses.replace(
        hypothesis(0.0), changes={quantity: Change(value, 0.1, 0)}, misfits={"mru_heave": 1.0, "unit_heave": 1.0}
    )
    assert (accepted([one, present], present, None, ["mru_heave", "unit_heave"]) is one) is is_accepted


@pytest.mark.parametrize(
    ("motion", "is_used"), [(0.9 * TELLING, False), (1.1 * TELLING, True), (math.nan, False)], ids=str
)
def test_a_sensor_that_was_left_out_shows_that_it_is_right_by_motion_alone(motion, is_used):
    """One that reads nothing but its mean agrees with all others in a calm; NaN: it reads nothing at all."""
    without = dataclasses.replace(PRESENT, excluded="depth", motion=motion)
    again = hypothesis(0.0)
    assert (accepted([again, without], without, again, ["mru_heave"]) is again) is is_used
    # another finding beside it says nothing of the sensor
    other = dataclasses.replace(hypothesis(0.0, ["mru.scale"]), excluded="depth")
    assert accepted([other, without], without, other, ["mru_heave"]) is other


def test_a_sensor_that_is_used_again_blames_another_only_for_what_it_explains_beyond_that():
    """A record that began with the end of a fault of the depth sensor was explained a little better by the MRU."""
    without = dataclasses.replace(PRESENT, excluded="depth", motion=2.0 * TELLING)
    again, other = hypothesis(20.0), hypothesis(20.0 - ACCEPTED + 0.1, ["mru.scale"])
    ranked = [other, again, without]
    assert accepted(ranked, without, None, ["mru_heave"]) is None
    assert accepted(ranked, without, other, ["mru_heave"]) is other


def test_what_is_believed_is_not_news():
    assert accepted([PRESENT], PRESENT, PRESENT, ["mru_heave"]) is None


def test_what_was_another_culprit_a_look_before_is_not_again():
    one, other = hypothesis(70.0, ["mru.scale"]), hypothesis(70.0, ["cable.inertia_factor"])
    assert accepted([one, PRESENT], PRESENT, other, ["mru_heave"]) is None


def change_of(name, value):
    return {name: Change(value, 0.1, 0)}


@given(st.sampled_from(sorted(PRICES)), st.floats(0.3, 3.0))
def test_all_that_is_not_nominal_has_its_price(name, value):
    from_nominal = assumed(BELIEF)
    nominal = QUANTITIES[name].nominal_in(BELIEF.parameters)
    assert from_nominal.price({}, "") == 0.0
    assert from_nominal.price(change_of(name, nominal), "") == 0.0
    price = from_nominal.price(change_of(name, nominal + value), "")
    assert price >= PRICES[name]
    # two things that are wrong cost what each does
    depth = from_nominal.price({}, "depth")
    assert depth == EXCLUSION
    assert from_nominal.price(change_of(name, nominal + value), "depth") == pytest.approx(price + depth)


BELIEF = designed()


def test_a_scale_that_is_off_by_more_costs_more_and_a_wrong_sign_more_than_that():
    one = assumed(BELIEF)
    prices = [one.price(change_of("mru.scale", value), "") for value in (1.1, 1.5, 3.0)]
    assert prices == sorted(prices)
    assert one.price(change_of("mru.scale", -1.0), "") > PRICES["mru.scale"]
    assert one.price(change_of("mru.scale", 0.5), "") == pytest.approx(one.price(change_of("mru.scale", 2.0), ""))


def test_what_the_encoder_reads_of_what_was_sent_is_the_winch_s_or_the_encoder_s():
    """A drum of half the gain by the encoder: cheap once the encoder is assumed to read half, dear until then."""
    one = assumed(BELIEF, drum_gain=0.5)
    assert one.price(change_of("encoder.scale", 0.5), "") < one.price({}, "") + PRICES["encoder.scale"] + 2.0
    assert one.price(change_of("encoder.scale", 2.0), "") > one.price({}, "")
    assert one.price(change_of("encoder.scale", -0.5), "") >= 100.0
