"""The mode machine: what it does with the table."""

import dataclasses
import math
import re

import numpy as np
import pytest
from heave_node.interface.codes import WinchFault
from winch_controller_node.core.supervision.modes import WAIT, Mode, ModeError
from winch_controller_node.parameters.laws import ModeParameters

from tests.supervised import Machine, Told

DT = 0.05
WELL = Told(lost="", has_estimate=True, winch_fault=WinchFault.NONE, harm="", speed=0.0)
PARAMETERS = ModeParameters(settling_time=1.0, fade_in_time=2.0, fade_out_time=2.0, coast_time=1.5, resume_time=3.0)


def machine(*, moves_winch=True, resume=True, **times):
    parameters = dataclasses.replace(PARAMETERS, resume=resume, **times)
    return Machine(parameters, moves_winch=moves_winch, factor=1.0, tick_period=DT)


def run(modes, seconds, situation=WELL):
    return [modes.step(situation) for _ in range(round(seconds / DT))]


def situation(**changes):
    values = {"lost": "", "has_estimate": True, "winch_fault": 0, "harm": "", "speed": 0.0} | changes
    return Told(**values)


def test_compensation_starts_by_itself_and_authority_rises_without_a_step():
    modes = machine()
    outputs = run(modes, 5.0)
    authority = [output.authority for output in outputs]
    assert modes.mode is Mode.COMPENSATING
    assert authority[0] == 0.0
    assert authority[-1] == 1.0
    assert np.max(np.abs(np.diff(authority))) <= DT / 2.0 + 1e-12


def test_another_factor_takes_authority_there_without_a_step_up_and_down():
    modes = machine()
    run(modes, 5.0)
    for factor in (0.25, 0.75, 0.0, 1.0):
        modes.set_factor(factor)
        authority = [output.authority for output in run(modes, 2.5)]
        assert np.max(np.abs(np.diff(authority))) <= DT / 2.0 + 1e-12
        assert authority[-1] == pytest.approx(factor)
    assert modes.mode is Mode.COMPENSATING


def test_law_off_keeps_the_brake_on_and_refuses_to_move():
    modes = machine(moves_winch=False)
    assert all(output.brake for output in run(modes, 5.0))
    with pytest.raises(ModeError, match="law off"):
        modes.request("compensating")


def test_a_lost_mru_is_coasted_over_then_faded_then_stopped_then_forgiven():
    modes = machine()
    run(modes, 5.0)
    lost = situation(lost="mru frozen", speed=0.3)
    assert run(modes, 1.4, lost)[-1].mode is Mode.COMPENSATING
    assert "coasting" in modes.reason
    assert run(modes, 0.3, lost)[-1].mode is Mode.FADE_OUT
    assert run(modes, 2.0, lost)[-1].mode is Mode.STOPPING
    assert run(modes, 0.1, situation(lost="mru frozen"))[-1].mode is Mode.STOPPED
    assert modes.reason == "mru frozen; compensation resumes automatically once the sensor is good"
    run(modes, 2.9)
    assert modes.mode is Mode.STOPPED
    run(modes, 2.0)
    assert modes.mode is Mode.COMPENSATING


def test_a_mode_that_a_lost_sensor_has_ended_for_good_says_that_it_must_be_asked_for():
    modes = machine(resume=False)
    run(modes, 5.0)
    run(modes, 1.7, situation(lost="mru frozen", speed=0.3))
    assert modes.reason.endswith("resumes automatically only while authority falls; after that request it")
    run(modes, 1.5)
    assert modes.mode is Mode.COMPENSATING  # as the reason says


def test_a_frozen_encoder_is_said_to_be_good_again_only_once_its_reading_changes():
    """Below a drum that rests it reads the same whether frozen or not: an operator must ask."""
    modes = machine()
    run(modes, 5.0)
    run(modes, 2.0, situation(lost="encoder frozen", speed=0.3))
    assert modes.reason.endswith("resumes automatically once the count changes, or on request")
    run(modes, 60.0, situation(lost="encoder frozen"))
    assert modes.mode is Mode.STOPPED
    assert modes.obstacle == "", "a request tries it again"
    run(modes, 5.0)
    assert modes.mode is Mode.COMPENSATING


def resumed_after(modes, longest):
    """Return how long compensation took to resume with a good sensor [s]; infinite: longer than the longest."""
    for count in range(round(longest / DT)):
        if run(modes, DT)[-1].mode is Mode.COMPENSATING:
            return count * DT
    return math.inf


def test_each_loss_of_a_sensor_that_comes_and_goes_takes_longer_and_a_count_ends_it():
    """It was resumed a second after each of twenty losses."""
    modes = machine(fade_out_time=600.0)
    run(modes, 5.0)
    waits = []
    for _ in range(4):
        run(modes, 2.0, situation(lost="mru frozen", speed=0.3))
        waits.append(resumed_after(modes, 100.0))
    assert waits == pytest.approx([1.0, 4.0, 16.0, math.inf], abs=2.0 * DT)
    assert modes.reason == "mru frozen; a sensor was lost 4 times: request a mode once it is good and stays so"
    modes.request("compensating")
    assert modes.mode is Mode.COMPENSATING
    run(modes, 2.0, situation(lost="mru frozen", speed=0.3))
    assert resumed_after(modes, 100.0) == pytest.approx(1.0, abs=2.0 * DT)


def test_a_sensor_that_comes_and_goes_is_waited_for_as_long_as_the_reason_says_also_after_the_stop():
    """It said 16 s, and the winch stood for four minutes beside a good sensor: after a stop the wait is another."""
    modes = machine()
    run(modes, 5.0)
    run(modes, 2.0, situation(lost="mru frozen", speed=0.3))
    assert resumed_after(modes, 100.0) < 2.0
    run(modes, 6.0, situation(lost="mru frozen"))
    assert modes.mode is Mode.STOPPED
    (said,) = re.findall(r"good for 4 s, (\d+) s once the winch has stopped", modes.reason)
    run(modes, float(said) - 0.5)
    assert modes.mode is Mode.STOPPED
    run(modes, 1.0)
    assert modes.mode is not Mode.STOPPED


def test_losses_are_forgotten_after_ten_minutes_of_compensation():
    modes = machine(fade_out_time=600.0)
    run(modes, 5.0)
    for _ in range(5):
        run(modes, 2.0, situation(lost="mru frozen", speed=0.3))
        assert resumed_after(modes, 100.0) == pytest.approx(1.0, abs=2.0 * DT)
        run(modes, 610.0)


@pytest.mark.parametrize(("lost", "good", "ends"), [(0.5, 1.5, True), (0.3, 3.0, False)])
def test_a_sensor_that_is_lost_every_other_moment_is_lost(lost, good, ends):
    """Each time for less than it is predicted for: compensation went on with it for ever."""
    modes = machine()
    run(modes, 5.0)
    reached = []
    for _ in range(30):
        reached += run(modes, lost, situation(lost="encoder frozen", speed=0.3)) + run(modes, good)
    assert any(output.mode is Mode.FADE_OUT for output in reached) is ends


def test_hiccups_of_a_sensor_do_not_put_compensation_off_for_ever():
    """Four readings of the encoder that are late each second, while the estimate settles for two."""
    modes = machine()
    late = situation(lost="encoder stale")
    for _ in range(5):
        run(modes, 0.8)
        assert run(modes, 0.2, late)[-1].brake == (modes.mode is Mode.STANDBY)
    assert modes.mode is Mode.COMPENSATING


def test_what_did_not_compensate_does_not_resume_with_a_sensor_and_says_so():
    modes = machine()
    run(modes, 5.0)
    modes.request("standby")
    run(modes, 5.0)
    modes.request("manual")
    run(modes, 5.0, situation(lost="encoder frozen", speed=0.3))
    assert modes.mode not in (Mode.MANUAL, Mode.COMPENSATING)
    assert modes.reason.endswith("request a mode once the sensor is good")


def test_a_unit_that_was_damped_blind_is_given_half_a_minute_to_settle_from_the_request_on():
    modes = machine()
    run(modes, 5.0)
    run(modes, 60.0, situation(lost="mru frozen", is_damped_blind=True, is_settled=False))
    modes.request("stopped")
    assert run(modes, 25.0, situation(is_settled=False, speed=0.3))[-1].mode is Mode.FADE_OUT
    assert run(modes, 10.0, situation(is_settled=False, speed=0.3))[-1].mode is Mode.STOPPING


def test_an_emergency_stop_brakes_at_once_and_waits_for_somebody():
    modes = machine()
    run(modes, 5.0)
    modes.request("emergency_stop")
    assert modes.step(WELL).brake
    assert run(modes, 60.0)[-1].mode is Mode.EMERGENCY_STOP
    modes.request("compensating")
    run(modes, 2.0)
    assert modes.mode is Mode.COMPENSATING


@pytest.mark.parametrize(
    ("fault", "mode", "words"),
    [
        (WinchFault.DRIVE, Mode.STOPPED, "winch fault: drive; request a mode once it is cleared"),
        (
            WinchFault.EMERGENCY_STOP,
            Mode.EMERGENCY_STOP,
            "winch fault: emergency stop; request a mode once it is cleared",
        ),
        (99, Mode.STOPPED, "winch fault: unknown fault 99; request a mode once it is cleared"),
    ],
)
def test_a_fault_of_the_winch_brakes_is_told_in_words_and_is_not_forgiven_by_itself(fault, mode, words):
    modes = machine()
    run(modes, 5.0)
    assert run(modes, 0.1, situation(winch_fault=fault))[-1].brake
    after = run(modes, 60.0)[-1]
    assert (after.mode, after.reason) == (mode, words)


@pytest.mark.parametrize(
    ("fault", "mode"),
    [
        (WinchFault.EMERGENCY_STOP, Mode.EMERGENCY_STOP),
        (WinchFault.DRIVE, Mode.STOPPED),
        (WinchFault.INVALID_COMMAND, Mode.STOPPED),
        (99, Mode.STOPPED),
    ],
)
def test_a_fault_while_a_winch_is_stopped_for_a_lost_sensor_is_not_forgiven_with_the_sensor(fault, mode):
    """Somebody who presses the emergency stop of a winch that rests must find it at rest."""
    modes = machine()
    run(modes, 30.0)
    assert run(modes, 60.0, situation(lost="mru lost: stale"))[-1].mode is Mode.STOPPED
    assert run(modes, 1.0, situation(lost="mru lost: stale", winch_fault=fault))[-1].mode is mode
    assert {output.mode for output in run(modes, 120.0)} == {mode}
    modes.request("compensating")
    assert run(modes, 60.0)[-1].mode is Mode.COMPENSATING


def test_a_winch_that_stopped_for_want_of_commands_while_a_sensor_was_lost_goes_on_with_the_sensor():
    modes = machine()
    run(modes, 30.0)
    run(modes, 60.0, situation(lost="mru lost: stale"))
    run(modes, 60.0, situation(lost="mru lost: stale", winch_fault=WinchFault.COMMAND_TIMEOUT))
    assert run(modes, 60.0)[-1].mode is Mode.COMPENSATING


def test_harm_fades_out_to_standby_and_comes_back_when_it_is_over():
    modes = machine()
    run(modes, 5.0)
    harm = situation(harm="compensation is harmful")
    outputs = run(modes, 3.0, harm)
    assert outputs[0].mode is Mode.FADE_OUT
    assert modes.mode is Mode.STANDBY
    run(modes, 5.0, harm)
    assert modes.mode is Mode.STANDBY
    run(modes, 1.5)
    assert modes.mode is Mode.COMPENSATING


def test_an_unknown_mode_is_refused_by_name():
    with pytest.raises(ModeError, match="'dance' cannot be requested"):
        machine().request("dance")


def test_what_compensation_waits_for_is_said_with_the_time_it_takes():
    modes = machine()
    run(modes, 0.5)
    assert modes.reason == "estimate settling, 0 s more"
    harm = situation(harm="compensation is harmful", prospect="tried again in 20 s")
    run(modes, 2.0, harm)
    assert modes.reason == "compensation is harmful; tried again in 20 s"


def test_compensation_that_ends_says_whether_and_when_it_comes_back():
    modes = machine()
    run(modes, 5.0)
    harm = situation(harm="compensation is harmful", prospect="tried again in 20 s")
    assert [output.reason for output in run(modes, 0.2, harm)] == ["compensation is harmful; tried again in 20 s"] * 4
    modes = machine()
    run(modes, 5.0)
    silent = situation(winch_fault=WinchFault.COMMAND_TIMEOUT, resumes_after_fault=True)
    run(modes, 1.0, silent)
    assert modes.reason.endswith(f"compensation resumes automatically {WAIT:g} s after commands reach the winch again")


def test_an_operator_who_asks_for_a_winch_that_stopped_for_a_fault_may_have_it_while_the_fault_is_still_told():
    """The fault that was there when it was asked for is known: it is reported until the brake has acknowledged it."""
    modes = machine()
    run(modes, 5.0)
    fault = situation(winch_fault=WinchFault.DRIVE)
    run(modes, 1.0, fault)
    modes.request("compensating")
    assert run(modes, 0.4, fault)[-1].mode is Mode.STANDBY
    another = situation(winch_fault=WinchFault.INVALID_COMMAND)
    assert run(modes, 0.1, another)[-1].mode is Mode.STOPPED


@pytest.mark.parametrize("is_requested", [False, True], ids=["there at the start", "there when asked for"])
def test_a_known_fault_that_was_cleared_is_a_new_one_when_it_comes_back(is_requested):
    modes = machine()
    fault = situation(winch_fault=WinchFault.DRIVE, has_estimate=False)
    if is_requested:
        run(modes, 0.1, situation(has_estimate=False))
        run(modes, 0.1, fault)
        modes.request("standby")
    assert run(modes, 0.5, fault)[-1].mode is Mode.STANDBY
    run(modes, 0.1, situation(has_estimate=False))
    assert run(modes, 0.1, fault)[-1].mode is Mode.STOPPED


def test_constant_tension_is_refused_with_its_reason_and_taken_without_one():
    modes = machine()
    run(modes, 5.0)
    run(modes, 0.1, situation(tension=lambda: "the unit is suspended"))
    with pytest.raises(ModeError, match=r"mode constant_tension needs: .*\(the unit is suspended\)"):
        modes.request("constant_tension")
    assert modes.mode is Mode.COMPENSATING
    run(modes, 0.1)
    modes.request("constant_tension")
    assert modes.mode is Mode.CONSTANT_TENSION


def test_a_unit_that_is_damped_blind_is_held_at_rest_until_its_sensor_is_back():
    modes = machine()
    run(modes, 5.0)
    blind = situation(lost="mru frozen", is_damped_blind=True, is_settled=False)
    run(modes, 60.0, blind)
    assert (modes.mode, modes.authority) == (Mode.FADE_OUT, 1.0)
    assert modes.reason.endswith("once the sensor is good; until then the depth sensor damps the load")
    assert run(modes, 1.5)[-1].mode is Mode.COMPENSATING
    run(modes, 5.0, blind)
    modes.request("stopped")
    assert run(modes, 3.0, blind)[-1].authority == 0.0, "an operator who asks for rest gets it"


def test_what_keeps_compensation_from_beginning_is_said():
    modes = machine()
    run(modes, 0.2, situation(lost="mru stale"))
    assert modes.obstacle == "mru stale; request it again once the sensor is good"
    run(modes, 0.2, situation(harm="drum speed off"))
    assert modes.obstacle == "drum speed off"
    run(modes, 0.2, situation(harm="drum speed off", awaits_operator=True, gates=lambda: "peaks of 2.0 m/s^2"))
    assert modes.obstacle == "peaks of 2.0 m/s^2", "who asks has looked at the cause"
    run(modes, 0.2)
    assert modes.obstacle == ""


def test_each_change_of_mode_is_told_once_with_the_mode_before():
    modes = machine()
    changes = [(output.before, output.mode) for output in run(modes, 5.0) if output.before is not None]
    assert changes == [(Mode.STANDBY, Mode.COMPENSATING)]
    modes.request("stopped")
    changes = [(output.before, output.mode) for output in run(modes, 5.0) if output.before is not None]
    assert changes == [
        (Mode.COMPENSATING, Mode.FADE_OUT),
        (Mode.FADE_OUT, Mode.STOPPING),
        (Mode.STOPPING, Mode.STOPPED),
    ]


def test_a_law_that_does_not_move_the_winch_says_so():
    assert machine(moves_winch=False).reason == "law off"
    assert machine().reason == "estimate settled"


@pytest.mark.parametrize(("shown", "limit", "begins"), [(0.7, 1.0, 0.7), (0.9, 0.4, 0.4), (0.0, 1.0, 0.0)])
@pytest.mark.parametrize("is_asked", [False, True], ids=["sensor back", "operator"])
def test_compensation_comes_back_from_a_fade_out_with_the_authority_that_unit_and_drum_show(
    shown, limit, begins, is_asked
):
    modes = machine(fade_out_time=600.0, fade_in_time=600.0)
    run(modes, 60.0)
    before = run(modes, 3.0, situation(lost="mru frozen"))[-1]
    back = situation(shown_authority=shown, authority_limit=limit)
    modes.step(back)
    if is_asked:
        modes.request("compensating")
    output = next(one for one in run(modes, 5.0, back) if one.mode is Mode.COMPENSATING)
    assert (before.mode, output.before) == (Mode.FADE_OUT, Mode.FADE_OUT)
    assert output.authority == pytest.approx(begins, abs=2.0 * DT / 600.0)
