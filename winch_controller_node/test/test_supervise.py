"""Supervision of a tick in the core: late depths, lost sensors, damping, lowering, and what follows an event."""

import math

import pytest
from heave_core.modes_table import SUPERVISED
from heave_node.interface.codes import WinchFault
from winch_controller_node.core.estimation.sense_design import BACK_TIME
from winch_controller_node.core.supervision.modes import Mode
from winch_controller_node.core.supervision.supervision_design import BLIND_LIMIT, LONGEST_AGE

from tests.supervised import DT, Supervised


def measured(loop):
    """Return the heave that the guard takes the depth sensor to read now [m]."""
    return float(loop.supervisor.guard.core.state["measured"]["last"][0])


@pytest.mark.parametrize("age", [0.0, 0.5, 3.0])
def test_a_depth_that_was_read_earlier_is_carried_to_now_by_the_estimate(age):
    """A unit that rises by 0.1 m/s, read without error, beside a mean heave of 0.2 m."""
    loop = Supervised()
    for tick in range(1, 201):
        now = tick * DT
        then = now - age
        reading = {"depths": ((then, 300.0),), "depth_heave": 0.1 * then} if then > 0.0 else {}
        loop.step(unit=0.1 * now + 0.2, mean_heave=0.2, **reading)
    assert measured(loop) == pytest.approx(0.1 * now + 0.2)


def test_a_depth_older_than_what_is_kept_is_carried_from_the_oldest():
    loop = Supervised()
    for tick in range(1, 401):
        loop.step(unit=0.1 * tick * DT)
    loop.step(unit=40.1 * 0.5 * 0.1, depths=((0.0, 300.0),), depth_heave=0.0)
    assert measured(loop) == pytest.approx(0.1 * LONGEST_AGE, abs=0.02)


def test_a_fade_out_without_the_boom_tip_is_damped_by_the_depth_sensor_for_a_quarter_of_an_hour():
    loop = Supervised(mode=Mode.FADE_OUT)
    given = {"knows_tip": 0, "winch": {"settled_swing": 0.1}, "lost": ("mru",)}
    for _ in range(round(BLIND_LIMIT / DT) - 2):
        decision = loop.step(**given)
    assert decision.is_damped
    assert not [loop.step(**given).is_damped for _ in range(4)][-1]


@pytest.mark.parametrize("how", ["jumped", "excluded"])
def test_constant_tension_does_not_go_by_a_load_cell_that_is_known_to_be_wrong(how):
    """One that read twice the tension paid out 6.2 m, after it had been said that constant tension is unreliable."""
    loop = Supervised(mode=Mode.CONSTANT_TENSION)
    assert loop.step().mode.mode is Mode.CONSTANT_TENSION
    if how == "excluded":
        loop.exclude("load_cell")
    given = {"speed": 1.0, "cell_jumped": how == "jumped"}
    decisions = [loop.step(winch=given) for _ in range(round((loop.design.parameters.modes.coast_time + 1.0) / DT))]
    assert decisions[-1].mode.mode is not Mode.CONSTANT_TENSION


@pytest.mark.parametrize(
    ("mode", "sensor", "ends"),
    [
        (Mode.COMPENSATING, "mru", True),
        (Mode.COMPENSATING, "encoder", True),
        (Mode.COMPENSATING, "load_cell", False),
        (Mode.CONSTANT_TENSION, "load_cell", True),
        (Mode.CONSTANT_TENSION, "mru", False),
        (Mode.MANUAL, "encoder", True),
        (Mode.MANUAL, "mru", False),
    ],
)
def test_each_mode_ends_without_the_sensors_that_it_requires(mode, sensor, ends):
    loop = Supervised(mode=mode)
    for _ in range(round((loop.design.parameters.modes.coast_time + 1.0) / DT)):
        decision = loop.step(lost=(sensor,), winch={"speed": 1.0})
    assert (decision.mode.mode is not mode) is ends


def test_lowering_without_a_depth_sensor_is_reported_once():
    loop, codes = Supervised(), []
    for tick in range(round(30.0 / DT)):
        decision = loop.step(mean_payout=0.1 * tick * DT, sees_landing=0, tension=1e5, filtered_tension=1e5)
        codes += [alarm.name for alarm in decision.alarms]
    assert codes.count("LOWERING_BLIND") == 1


def test_a_reversed_drum_is_brought_to_rest_undamped_until_an_operator_asks():
    loop = Supervised()
    decision = loop.step(winch={"is_reversed": True, "settled_swing": 0.1})
    assert decision.mode.mode is Mode.FADE_OUT
    trusts = loop.supervisor.done[[row.name for row in SUPERVISED.rows].index("trusts_estimate")]
    assert not (trusts or decision.is_damped)
    assert decision.mode.reason.endswith("check the cause, then request compensation")


def test_a_fault_of_the_winch_brakes_at_once_and_its_emergency_stop_stays():
    for fault, mode in ((WinchFault.DRIVE, Mode.STOPPED), (WinchFault.EMERGENCY_STOP, Mode.EMERGENCY_STOP)):
        loop = Supervised()
        loop.step()
        decision = loop.step(winch={"fault": int(fault)})
        assert (decision.mode.mode, decision.mode.brake, decision.mode.before) == (mode, True, Mode.COMPENSATING)


def test_a_settled_unit_lets_a_fade_out_end_and_one_that_swings_does_not():
    """Of a damped unit: 0.01 m in calm water."""
    for offset, ends in ((0.005, True), (0.02, False)):
        loop = Supervised(mode=Mode.FADE_OUT, wants=False)
        loop.supervisor.guard.core.attempts["inhibits"] = 1
        loop.supervisor.guard.core.attempts["is_present"] = 1
        decision = loop.step(offset=offset, winch={"settled_swing": 0.1, "speed": 1.0, "inhibition": None})
        assert decision.is_damped
        assert (decision.mode.mode is Mode.STOPPING) is ends


def test_a_fade_out_by_the_law_goes_on_over_a_gap_and_again_once_the_sensor_is_back():
    """A gap of a second in a fade-out that was requested left 1.7 times the swing: the law let the load go for good."""
    loop = Supervised()
    loop.run(30.0)
    loop.supervisor.modes.request("standby")
    by_law = [row.name for row in SUPERVISED.rows].index("fades_by_law")

    def lets_go(seconds, *lost):
        loop.run(seconds, lost=lost, offset=1.0, winch={"settled_swing": 0.1, "speed": 1.0})
        return bool(loop.supervisor.done[by_law])

    coasts = loop.design.parameters.modes.coast_time
    assert lets_go(1.0)
    assert lets_go(coasts - 0.5, "mru")
    assert lets_go(1.0)
    assert not lets_go(coasts + 0.5, "mru")
    assert lets_go(BACK_TIME + 0.5)


def test_a_fade_out_that_no_operator_has_requested_is_not_by_the_law():
    loop = Supervised()
    loop.run(loop.design.parameters.modes.coast_time + 0.5, lost=("mru",), winch={"speed": 1.0})
    assert loop.supervisor.modes.mode is Mode.FADE_OUT
    assert not loop.supervisor.done[[row.name for row in SUPERVISED.rows].index("fades_by_law")]


def test_a_decision_is_finite_in_whatever_is_read():
    """Nothing is known of a tick: no mode that moves the winch is entered, and no number of a decision is none."""
    loop = Supervised(mode=Mode.STANDBY)
    for _ in range(200):
        decision = loop.step(tip=math.nan, unit=math.nan, free=math.nan, has_encoder=0)
    assert decision.mode.mode is Mode.STANDBY
    assert math.isfinite(decision.mode.authority)
