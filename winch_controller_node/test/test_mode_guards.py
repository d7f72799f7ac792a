"""Where each event of a tick and each guard of the table of modes begins to hold, and what each action remembers."""

import pytest
from heave_node.interface.codes import WinchFault
from winch_controller_node.core.estimation.sense_design import BACK_TIME
from winch_controller_node.core.supervision.modes import (
    BRAKE_HELD,
    GATES_OPEN,
    HAS_ENCODER,
    MAY_HOLD_TENSION,
    MAY_RESUME,
    NEW_FAULT,
    NO_FAULT,
    NO_HARM,
    NOTHING_KNOWN,
    RELEASE_TIME,
    RELEASED_TIME,
    RESTS_IN_STANDBY,
    RESTS_STOPPED,
    SENSORS_WELL,
    SETTLED_ESTIMATE,
    SETTLING_LIMIT,
    STANDSTILL,
    STOPPING_LIMIT,
    TICK_EVENTS,
    WANTED,
    Event,
    Memory,
    Mode,
    Situation,
    View,
    compensate_all,
    compensate_nothing,
    end_in_standby,
    end_stopped,
    wait_for_operator,
    want_compensation,
    want_rest,
)
from winch_controller_node.parameters.laws import ModeParameters

PARAMETERS = ModeParameters(settling_time=1.0, fade_in_time=2.0, fade_out_time=2.0, coast_time=0.5, resume_time=3.0)
DRIVE, STOPPED = WinchFault.DRIVE, WinchFault.EMERGENCY_STOP
FADED_AT = PARAMETERS.fade_out_time + SETTLING_LIMIT


def view(**given):
    """Return what guards look at: all is well and at rest, but for what is `given` of view, situation and memory."""

    def part(kind, **usual):
        return kind(**{**usual, **{name: given.pop(name) for name in list(given) if name in kind._fields}})

    situation = part(Situation, lost="", has_estimate=True, winch_fault=WinchFault.NONE, harm="", speed=0.0)
    memory = part(Memory, wants_compensation=False)
    usual = {"factor": 0.8, "known_fault": WinchFault.NONE, "time": 0.0, "well_time": 0.0, "lost_time": 0.0}
    return View(**{"situation": situation, "memory": memory, "parameters": PARAMETERS, **usual, **given})


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
        (Event.WINCH_EMERGENCY_STOP, {"winch_fault": DRIVE}, False),
        (Event.WINCH_EMERGENCY_STOP, {"winch_fault": STOPPED, "known_fault": STOPPED}, False),
        (Event.WINCH_SILENT, {"lost": "encoder stale"}, True),
        (Event.WINCH_SILENT, {"lost": "encoder frozen"}, False),
        (Event.SENSOR_LOST, {"lost_time": PARAMETERS.coast_time}, False),
        (Event.SENSOR_LOST, {"lost_time": PARAMETERS.coast_time + 0.05}, True),
        (Event.HARM, {"harm": "compensation is harmful"}, True),
        (Event.HARM, {}, False),
        (Event.SENSORS_BACK, {"well_time": BACK_TIME}, False),
        (Event.SENSORS_BACK, {"well_time": BACK_TIME + 0.05}, True),
        (Event.SETTLED, {"well_time": 0.95}, False),
        (Event.SETTLED, {"well_time": 1.0}, True),
        (Event.SETTLED, {"well_time": 0.45, "parameters": ModeParameters(settling_time=0.0)}, False),
        (Event.SETTLED, {"well_time": RELEASE_TIME, "parameters": ModeParameters(settling_time=0.0)}, True),
        (Event.FADED, {}, True),
        (Event.FADED, {"authority": 0.01}, False),
        (Event.FADED, {"is_settled": False, "time": FADED_AT}, False),
        (Event.FADED, {"is_settled": False, "time": FADED_AT + 0.05}, True),
        (Event.FADED, {"is_settled": False, "time": FADED_AT + 0.05, "authority": 0.01}, False),
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
    assert TICK_EVENTS[event](view(**given)) is holds


def test_an_emergency_stop_of_the_winch_is_looked_for_before_any_other_fault_and_faults_before_sensors():
    order = list(TICK_EVENTS)
    assert order[:2] == [Event.WINCH_EMERGENCY_STOP, Event.WINCH_FAULT]
    assert order.index(Event.WINCH_SILENT) < order.index(Event.SENSOR_LOST) < order.index(Event.HARM)


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
        (HAS_ENCODER, {"lost": "encoder frozen"}, False),
        (SETTLED_ESTIMATE, {"well_time": 1.0}, True),
        (SETTLED_ESTIMATE, {"well_time": 0.95}, False),
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
    assert guard.holds(view(**given)) is holds
    assert guard.refusal(view(**given)).startswith(guard.name)


@pytest.mark.parametrize(
    ("guard", "given", "detail"),
    [
        (NO_HARM, {"harm": "peaks of 2 m/s"}, " (peaks of 2 m/s)"),
        (SENSORS_WELL, {"lost": "mru frozen", "lost_time": 1.0}, " (mru frozen)"),
        (GATES_OPEN, {"gates": lambda: "peaks"}, " (peaks)"),
        (MAY_HOLD_TENSION, {"tension": lambda: "suspended"}, " (suspended)"),
        (HAS_ENCODER, {"lost": "encoder frozen"}, ""),
    ],
)
def test_a_guard_that_does_not_hold_says_what_stands_against_it(guard, given, detail):
    assert guard.refusal(view(**given)) == guard.name + detail


@pytest.mark.parametrize(
    ("action", "remembered"),
    [
        (want_compensation, {"wants_compensation": True, "may_resume": True}),
        (want_rest, {"wants_compensation": False, "may_resume": True}),
        (wait_for_operator, {"wants_compensation": False, "may_resume": False}),
        (end_in_standby, {"rest": Mode.STANDBY}),
        (end_stopped, {"rest": Mode.STOPPED}),
        (compensate_nothing, {"authority": 0.0}),
        (compensate_all, {"authority": 0.8}),
    ],
)
@pytest.mark.parametrize("was", [True, False])
def test_an_action_remembers_what_it_says_and_changes_nothing_else(action, remembered, was):
    before = Memory(was, may_resume=was, rest=Mode.STOPPED if was else Mode.STANDBY, authority=0.3)
    given = view(memory=before)
    assert action(given) == before._replace(**remembered)


def test_nothing_is_lost_or_allowed_before_anything_is_known():
    """A machine that begins has an authority of 0, may resume, and comes to rest in standby."""
    assert Memory(wants_compensation=True) == (True, True, Mode.STANDBY, 0.0, 0)
    assert not NOTHING_KNOWN.has_estimate
    usual = NOTHING_KNOWN
    assert (usual.authority_limit, usual.is_settled, usual.is_damped_blind) == (1.0, True, False)
    assert (usual.awaits_operator, usual.resumes_after_fault) == (False, False)
