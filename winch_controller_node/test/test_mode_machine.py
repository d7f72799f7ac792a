"""The mode machine: what it does with the table."""

import dataclasses

import numpy as np
import pytest
from heave_node.interface.codes import WinchFault
from winch_controller_node.parameters.laws import ModeParameters
from winch_controller_node.supervision.mode_machine import ModeMachine
from winch_controller_node.supervision.modes import Mode, ModeError, Situation

DT = 0.05
WELL = Situation(lost="", has_estimate=True, winch_fault=WinchFault.NONE, harm="", speed=0.0)
PARAMETERS = ModeParameters(settling_time=1.0, fade_in_time=2.0, fade_out_time=2.0, coast_time=1.5, resume_time=3.0)


def machine(*, moves_winch=True, resume=True):
    parameters = dataclasses.replace(PARAMETERS, resume=resume)
    return ModeMachine(parameters, moves_winch=moves_winch, factor=1.0, tick_period=DT)


def run(modes, seconds, situation=WELL):
    return [modes.step(situation) for _ in range(round(seconds / DT))]


def situation(**changes):
    values = {"lost": "", "has_estimate": True, "winch_fault": 0, "harm": "", "speed": 0.0} | changes
    return Situation(**values)


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
        modes.factor = factor
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
    run(modes, 2.0, situation(lost="mru frozen", speed=0.3))
    assert modes.reason == "mru frozen; request a mode once the sensor is good"


def test_a_short_gap_does_not_end_compensation():
    modes = machine()
    run(modes, 5.0)
    run(modes, 1.0, situation(lost="mru stale"))
    assert run(modes, 0.1)[-1] == type(run(modes, 0.05)[-1])(Mode.COMPENSATING, "", 1.0, False)


def test_hiccups_of_a_sensor_do_not_put_compensation_off_for_ever():
    """Four readings of the encoder that are late each second, while the estimate settles for two."""
    modes = machine()
    late = situation(lost="encoder stale")
    for _ in range(5):
        run(modes, 0.8)
        assert run(modes, 0.2, late)[-1].brake == (modes.mode is Mode.STANDBY)
    assert modes.mode is Mode.COMPENSATING


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
        (WinchFault.DRIVE, Mode.STOPPED, "winch fault: drive"),
        (WinchFault.EMERGENCY_STOP, Mode.EMERGENCY_STOP, "winch fault: emergency stop"),
        (99, Mode.STOPPED, "winch fault: unknown fault 99"),
    ],
)
def test_a_fault_of_the_winch_brakes_is_told_in_words_and_is_not_forgiven_by_itself(fault, mode, words):
    modes = machine()
    run(modes, 5.0)
    assert run(modes, 0.1, situation(winch_fault=fault))[-1].brake
    after = run(modes, 60.0)[-1]
    assert (after.mode, after.reason) == (mode, words)


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
