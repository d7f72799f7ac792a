"""Where each event of a tick and each guard of the table of modes begins to hold, and what each action remembers."""

import pytest
from heave_core.library import fill, library
from heave_core.modes_table import ModeAction, ModeEvent
from heave_node.interface.codes import WinchFault
from winch_controller_node.core.estimation.sense_design import BACK_TIME
from winch_controller_node.core.supervision.modes import (
    BRAKE_HELD,
    GATES_OPEN,
    HAS_ENCODER,
    MAY_HOLD_TENSION,
    MAY_RESUME,
    MODES,
    NEW_FAULT,
    NO_FAULT,
    NO_HARM,
    RELEASE_TIME,
    RELEASED_TIME,
    RESTS_IN_STANDBY,
    RESTS_STOPPED,
    SENSORS_WELL,
    SETTLING_LIMIT,
    STANDSTILL,
    STOPPING_LIMIT,
    TABLE,
    WANTED,
    Event,
    Mode,
    event_number,
    mode_design,
)
from winch_controller_node.parameters.laws import ModeParameters

from tests.supervised import Machine, Told

DT = 0.05
PARAMETERS = ModeParameters(settling_time=1.0, fade_in_time=2.0, fade_out_time=2.0, coast_time=0.5, resume_time=3.0)
DRIVE, STOPPED = WinchFault.DRIVE, WinchFault.EMERGENCY_STOP
FADED_AT = PARAMETERS.fade_out_time + SETTLING_LIMIT
USUAL = {"wants": 0, "may_resume": 1, "rest": Mode.STANDBY, "authority": 0.0, "known_fault": 0, "factor": 0.8}
TIMES = {"time": 0.0, "well_time": 0.0, "lost_time": 0.0}


def machine(mode, *, earlier=0.0, parameters=PARAMETERS, wants_compensation=None, **given):
    """Return a machine in a `mode` and its inputs, with what is `given` of both; its times are so much `earlier`."""
    modes = Machine(parameters, moves_winch=True, factor=0.8, tick_period=DT)
    told = Told(**{name: given.pop(name) for name in list(given) if name in Told._fields})
    state = {**USUAL, **TIMES, **({} if wants_compensation is None else {"wants": wants_compensation}), **given}
    state["rest"] = MODES.index(state["rest"])
    for name in TIMES:
        state[name] = state[name] - earlier
    modes.mode = mode
    for name, value in {**state, "mode": MODES.index(mode), "before": MODES.index(mode)}.items():
        modes.state[name] = value
    return modes, told


HAPPENS_IN = {
    Event.WINCH_FAULT: (Mode.MANUAL, {}),
    Event.WINCH_EMERGENCY_STOP: (Mode.MANUAL, {}),
    Event.WINCH_SILENT: (Mode.FADE_OUT, {"rest": Mode.STOPPED, "authority": 0.9}),
    Event.SENSOR_LOST: (Mode.COMPENSATING, {}),
    Event.HARM: (Mode.COMPENSATING, {}),
    Event.SENSORS_BACK: (Mode.FADE_OUT, {"rest": Mode.STOPPED, "wants": 1, "authority": 0.9}),
    Event.SETTLED: (Mode.STANDBY, {"wants": 1, "time": 9.0}),
    Event.FADED: (Mode.FADE_OUT, {}),
    Event.AT_REST: (Mode.STOPPING, {}),
}
"""A mode, and what else is there, in which an event needs nothing else to change it."""


@pytest.mark.parametrize(
    ("event", "given", "holds"),
    [
        (Event.WINCH_FAULT, {}, False),
        (Event.WINCH_FAULT, {"winch_fault": DRIVE}, True),
        (Event.WINCH_FAULT, {"winch_fault": DRIVE, "known_fault": DRIVE, "time": RELEASED_TIME}, False),
        (Event.WINCH_FAULT, {"winch_fault": DRIVE, "known_fault": DRIVE, "time": RELEASED_TIME + 0.05}, True),
        (Event.WINCH_FAULT, {"winch_fault": DRIVE, "known_fault": STOPPED}, True),
        (Event.WINCH_FAULT, {"known_fault": DRIVE, "time": RELEASED_TIME + 0.05}, False),
        (Event.WINCH_EMERGENCY_STOP, {"winch_fault": STOPPED}, True),
        (Event.WINCH_EMERGENCY_STOP, {"winch_fault": STOPPED, "known_fault": STOPPED}, False),
        (Event.WINCH_SILENT, {"lost": "encoder stale"}, True),
        (Event.WINCH_SILENT, {"lost": "encoder frozen"}, False),
        (Event.SENSOR_LOST, {"lost": "mru frozen", "lost_time": PARAMETERS.coast_time}, False),
        (Event.SENSOR_LOST, {"lost": "mru frozen", "lost_time": PARAMETERS.coast_time + 0.05}, True),
        (Event.HARM, {"harm": "compensation is harmful"}, True),
        (Event.HARM, {}, False),
        (Event.SENSORS_BACK, {"well_time": BACK_TIME}, False),
        (Event.SENSORS_BACK, {"well_time": BACK_TIME + 0.05}, True),
        (Event.SETTLED, {"well_time": 0.95}, False),
        (Event.SETTLED, {"well_time": 1.0}, True),
        (Event.SETTLED, {"well_time": 0.45, "parameters": ModeParameters(settling_time=0.0)}, False),
        (Event.SETTLED, {"well_time": RELEASE_TIME, "parameters": ModeParameters(settling_time=0.0)}, True),
        (Event.FADED, {}, True),
        (Event.FADED, {"authority": 0.1}, False),
        (Event.FADED, {"is_settled": False, "time": FADED_AT}, False),
        (Event.FADED, {"is_settled": False, "time": FADED_AT + 0.05}, True),
        (Event.FADED, {"is_settled": False, "time": FADED_AT + 0.05, "authority": 0.1}, False),
        (Event.FADED, {"is_damped_blind": True, "wants_compensation": True}, False),
        (Event.FADED, {"is_damped_blind": True, "wants_compensation": True, "time": FADED_AT + 0.05}, False),
        (Event.FADED, {"is_damped_blind": True}, True),
        (Event.FADED, {"wants_compensation": True}, True),
        (Event.AT_REST, {"speed": STANDSTILL, "time": STOPPING_LIMIT}, False),
        (Event.AT_REST, {"speed": 0.9 * STANDSTILL}, True),
        (Event.AT_REST, {"speed": STANDSTILL, "time": STOPPING_LIMIT + 0.05}, True),
    ],
)
def test_an_event_of_a_tick_happens_from_its_limit_on(event, given, holds):
    mode, usual = HAPPENS_IN[event]
    modes, told = machine(mode, earlier=DT, **{"speed": 1.0, **usual, **given})
    modes.step(told)
    assert (modes.mode is not mode) is holds


def test_an_emergency_stop_of_the_winch_is_looked_for_before_any_other_fault_and_faults_before_sensors():
    order = list(ModeEvent)
    assert order.index(ModeEvent.ON_WINCH_EMERGENCY_STOP) < order.index(ModeEvent.ON_WINCH_FAULT)
    sensors = ModeEvent.ON_WINCH_SILENT, ModeEvent.ON_SENSOR_LOST, ModeEvent.ON_HARM
    assert order.index(ModeEvent.ON_WINCH_FAULT) < min(map(order.index, sensors))
    assert sorted(sensors, key=order.index) == list(sensors)


def missing(modes, told, mode, event):
    """Return the guards that keep the first row of an `event` in a `mode` from being taken."""
    fill(modes.situation[0], told.numbers)
    design, situation, state = (one.ctypes.data for one in (modes.design, modes.situation, modes.state))
    return library().heave_core_modes_missing(design, situation, event_number(event), state)


RESUMES = {"well_time": PARAMETERS.resume_time + 0.05}


@pytest.mark.parametrize(
    ("guard", "given", "holds"),
    [
        (WANTED, {"wants_compensation": True}, True),
        (WANTED, {}, False),
        (NO_HARM, {}, True),
        (NO_HARM, {"harm": "peaks"}, False),
        (NO_FAULT, {}, True),
        (NO_FAULT, {"winch_fault": DRIVE}, False),
        (NEW_FAULT, {"winch_fault": DRIVE}, True),
        (NEW_FAULT, {"winch_fault": DRIVE, "known_fault": DRIVE}, False),
        (SENSORS_WELL, {}, True),
        (SENSORS_WELL, {"lost_time": 0.05}, False),
        (GATES_OPEN, {}, True),
        (GATES_OPEN, {"gates": lambda: "peaks"}, False),
        (MAY_HOLD_TENSION, {}, True),
        (MAY_HOLD_TENSION, {"tension": lambda: "the unit is suspended"}, False),
        (BRAKE_HELD, {"time": RELEASE_TIME}, True),
        (BRAKE_HELD, {"time": RELEASE_TIME - 0.05}, False),
        (HAS_ENCODER, {"lost": "mru frozen"}, True),
        (HAS_ENCODER, {"lost": "encoder frozen"}, True),  # an operator wants it to be tried again
        (HAS_ENCODER, {"lost": "encoder stale"}, False),
        (RESTS_IN_STANDBY, {}, True),
        (RESTS_IN_STANDBY, {"rest": Mode.STOPPED}, False),
        (RESTS_STOPPED, {"rest": Mode.STOPPED}, True),
        (RESTS_STOPPED, {}, False),
        (MAY_RESUME, RESUMES, True),
        (MAY_RESUME, {"well_time": PARAMETERS.resume_time}, False),
        (MAY_RESUME, {**RESUMES, "may_resume": False}, False),
        (MAY_RESUME, {**RESUMES, "parameters": ModeParameters(resume_time=3.0, resume=False)}, False),
    ],
)
def test_a_guard_holds_where_its_words_do(guard, given, holds):
    seen = set()
    first = [
        row for row in TABLE if (row.sources[0], row.event) not in seen and not seen.add((row.sources[0], row.event))
    ]
    row = next(row for row in first if guard in row.guards)
    modes, told = machine(row.sources[0], **given)
    is_missing = bool(missing(modes, told, row.sources[0], row.event) & guard.number)
    assert is_missing is not holds
    assert guard.refusal(told.words).startswith(guard.name)


@pytest.mark.parametrize(
    ("guard", "given", "detail"),
    [
        (NO_HARM, {"harm": "peaks of 2 m/s"}, " (peaks of 2 m/s)"),
        (SENSORS_WELL, {"lost": "mru frozen"}, " (mru frozen)"),
        (GATES_OPEN, {"gates": lambda: "peaks"}, " (peaks)"),
        (MAY_HOLD_TENSION, {"tension": lambda: "suspended"}, " (suspended)"),
        (HAS_ENCODER, {"lost": "encoder frozen"}, ""),
    ],
)
def test_a_guard_that_does_not_hold_says_what_stands_against_it(guard, given, detail):
    assert guard.refusal(Told(**given).words) == guard.name + detail


@pytest.mark.parametrize(
    ("action", "remembered"),
    [
        (ModeAction.DO_WANT_COMPENSATION, {"wants": 1, "may_resume": 1, "losses": 0}),
        (ModeAction.DO_WANT_REST, {"wants": 0, "may_resume": 1, "losses": 0}),
        (ModeAction.DO_WAIT_FOR_OPERATOR, {"wants": 0, "may_resume": 0}),
        (ModeAction.DO_END_IN_STANDBY, {"rest": MODES.index(Mode.STANDBY)}),
        (ModeAction.DO_END_STOPPED, {"rest": MODES.index(Mode.STOPPED)}),
        (ModeAction.DO_COMPENSATE_NOTHING, {"authority": 0.0}),
        (ModeAction.DO_COMPENSATE_ALL, {"authority": 0.8}),
        (ModeAction.DO_COUNT_LOSS, {"losses": 2}),
    ],
)
@pytest.mark.parametrize("was", [True, False])
def test_an_action_remembers_what_it_says_and_changes_nothing_else(action, remembered, was):
    rest = Mode.STOPPED if was else Mode.STANDBY
    modes, _ = machine(Mode.MANUAL, wants=was, may_resume=was, rest=rest, authority=0.3, losses=1)
    values, row = mode_design(PARAMETERS, DT), {"mode": MODES.index(Mode.MANUAL), "event": 0, "guards": 0}
    values["rows"][0] = {**row, "target": row["mode"], "actions": (action, 0, 0)}
    fill(modes.design[0], {**values, "count": 1})
    before = dict(zip(modes.state.dtype.names, modes.state[0].item(), strict=True))
    design, situation, state = (one.ctypes.data for one in (modes.design, modes.situation, modes.state))
    assert library().heave_core_modes_event(design, situation, 0, state)
    after = dict(zip(modes.state.dtype.names, modes.state[0].item(), strict=True))
    assert after == {**before, **remembered}


def test_nothing_is_lost_or_allowed_before_anything_is_known():
    """A machine that begins has an authority of 0, may resume, and comes to rest in standby."""
    modes = Machine(PARAMETERS, moves_winch=True, factor=1.0, tick_period=DT)
    state = modes.state[0]
    assert (modes.wants_compensation, int(state["may_resume"]), modes.authority) == (True, 1, 0.0)
    assert int(state["rest"]) == MODES.index(Mode.STANDBY)
