"""When an operator's request is done, and what is reported to the operator."""

import pytest
from heave_bringup.operate.moves import Followed, Lowering, MoveBy
from heave_bringup.operate.requests import Answer, refusal
from heave_bringup.operate.situation import PAUSED, RUNNING, RunStatus
from heave_bringup.operate.tasks import AnyOf, ClockTask, EmergencyStop, Stop

from bringup.test.operate_fakes import FakeLink, Given

MODE, DRIVE = "controller/set_mode", "virtual_winch/inject_fault"


def test_an_emergency_stop_is_done_when_the_winch_itself_says_that_it_is_braked_and_at_rest():
    link = FakeLink()
    link.winch_says(5.0, brake=False, rate=0.8)
    stop = EmergencyStop(link)
    assert link.requests[0].message.mode == "emergency_stop"
    assert stop.poll() is None
    link.winch_says(5.05, brake=True, rate=0.4)  # braked, but it still turns
    assert stop.poll() is None
    link.winch_says(5.4, brake=True, rate=0.0)
    answer = stop.poll()
    assert not answer.is_refused
    assert answer.text == "emergency stop by the controller: the brake is on and the drum at rest, 0.40 s later"
    assert link.asked == [MODE]


@pytest.mark.parametrize("answer", [None, refusal("controller/set_mode: nobody serves it")])
def test_an_emergency_stop_that_the_controller_does_not_take_goes_to_the_winch_itself(answer):
    link = FakeLink(lambda request: answer if request.service == MODE else Answer("pressed"))
    stop = EmergencyStop(link)
    stop.poll()
    link.wall_time = 1.1
    stop.poll()
    assert link.asked == [MODE, DRIVE]
    assert (link.requests[1].message.device, link.requests[1].message.kind) == ("winch", "emergency_stop")
    link.winch_says(5.5, brake=True)
    text = stop.poll().text
    assert text.startswith("emergency stop by the winch itself: the brake is on")
    assert text.endswith("until fault clear winch")


def test_an_emergency_stop_that_nobody_takes_says_so_and_what_to_do():
    link = FakeLink(lambda request: refusal(f"{request.service}: nobody serves it"))
    stop = EmergencyStop(link)
    link.winch_says(5.2, brake=True)  # braked by chance: nobody has taken the stop
    answers = [stop.poll() for _ in range(3)]
    answer = next(answer for answer in answers if answer is not None)
    assert answer.is_refused
    assert answer.text.startswith("NOT STOPPED: controller/set_mode: nobody serves it; virtual_winch/inject_fault")
    assert answer.text.endswith("press the emergency stop of the winch itself")


def test_an_emergency_stop_whose_drum_goes_on_turning_is_not_called_done():
    link = FakeLink()
    stop = EmergencyStop(link)
    for tick in range(240):
        link.winch_says(5.0 + 0.05 * tick, brake=True, rate=1.0)
        answer = stop.poll()
        if answer is not None:
            break
    assert answer is not None
    assert answer.is_refused
    assert "NOT STOPPED" in answer.text


def test_an_emergency_stop_of_a_silent_run_ends_with_a_refusal():
    link = FakeLink()
    stop = EmergencyStop(link)
    link.wall_time = 20.0
    assert stop.poll().is_refused


def test_an_emergency_stop_of_a_paused_run_is_in_force_from_the_next_tick():
    link = FakeLink()
    link.situation.run = RunStatus(PAUSED, tick=100, time=5.0)
    assert EmergencyStop(link).poll().text.endswith("active from the next tick, the run is paused")


def test_a_stop_is_done_when_the_winch_has_stopped_and_not_before():
    link = FakeLink()
    stop = Stop(link)
    assert stop.poll() is None  # what the controller said before the stop was taken does not count
    for time, mode in ((5.05, "fade_out"), (15.0, "stopping")):
        link.says(time, mode)
        assert stop.poll() is None
    link.says(16.0, "stopped")
    assert stop.poll() == Answer("stopped at t = 16.00 s, the brake is on")


def test_a_stop_that_somebody_else_undoes_is_not_called_done():
    link = FakeLink()
    stop = Stop(link)
    stop.poll()
    link.says(6.0, "compensating")
    assert stop.poll().is_refused


def test_a_refusal_is_the_answer_in_the_words_of_the_node():
    link = FakeLink(lambda _: refusal("the controller is inactive: activate it first"))
    assert Stop(link).poll() == refusal("the controller is inactive: activate it first")
    assert ClockTask(link, is_paused=True).poll() == refusal("the controller is inactive: activate it first")


def test_a_pause_is_done_when_the_run_shows_it():
    link = FakeLink()
    pause = ClockTask(link, is_paused=True)
    assert link.requests[0].message.data is True
    assert pause.poll() is None
    link.situation.run = RunStatus(PAUSED, tick=102, time=5.1)
    assert pause.poll() == Answer("paused at t = 5.10 s (tick 102)")


def test_a_step_is_done_after_its_ticks_and_waits_as_long_as_the_run_goes_on():
    link = FakeLink()
    link.situation.run = RunStatus(PAUSED, tick=100, time=5.0)
    step = ClockTask(link, ticks=200)
    assert step.poll() is None  # still paused where it was
    for tick in (120, 180, 240):
        link.wall_time += 4.0
        link.situation.run = RunStatus(RUNNING, tick=tick, time=tick * 0.05)
        assert step.poll() is None
    link.situation.run = RunStatus(PAUSED, tick=300, time=15.0)
    assert step.poll() == Answer("paused at t = 15.00 s (tick 300)")


def test_a_pause_that_the_run_never_shows_is_late_after_a_bound():
    link = FakeLink()
    pause = ClockTask(link, is_paused=True)
    pause.poll()
    link.wall_time = 5.1
    assert pause.poll().is_refused


def test_a_speed_is_asked_for_again_and_again_then_zero_then_told_by_what_the_payout_did():
    link = FakeLink()
    lowering = Lowering(link, 0.2, 1.0)
    answer, tick = None, 0
    while answer is None:
        link.says(5.0 + 0.05 * tick, payout=min(0.01 * tick, 0.2))
        answer, tick = lowering.poll(), tick + 1
    assert answer == Answer("speed +0.2 m/s for 1.0 s: the mean payout moved by +0.20 m")
    asked = [speed for speed in link.speeds if speed]
    assert set(asked) == {0.2}
    assert len(asked) == pytest.approx(10, abs=1)  # at 10 Hz
    assert link.speeds[-1] == 0.0


def test_a_speed_that_is_limited_is_answered_with_the_limit_in_the_controllers_words():
    link = FakeLink()
    lowering = Lowering(link, 0.5, 1.0)
    limited = "0.50 m/s requested, limit 0.30 m/s."
    told = f"CABLE_SLACK (medium): tension 1.0 kN.; OPERATOR_SPEED_LIMITED (low): {limited}"
    answer, tick = None, 0
    while answer is None:
        link.says(5.0 + 0.05 * tick)
        # diagnostics tell it for a second
        link.situation.note("winch_controller: alarms", 1 if 10 <= tick < 30 else 0, told)
        answer, tick = lowering.poll(), tick + 1
    assert answer == Answer(f"speed +0.5 m/s for 1.0 s: the mean payout moved by +0.00 m; {limited}")


def test_a_speed_that_is_let_go_ends_at_once():
    link = FakeLink()
    lowering = Lowering(link, 0.2, 100.0)
    lowering.poll()
    lowering.cancel()
    assert link.speeds == [0.2, 0.0]
    for tick in range(1, 80):
        link.says(5.0 + 0.05 * tick)
        lowering.poll()
    assert set(link.speeds[1:]) == {0.0}
    assert not lowering.poll().is_refused


def test_a_speed_is_refused_where_the_controller_would_not_follow_it():
    link = FakeLink()
    link.says(5.0, "standby")
    assert Lowering(link, 0.1, 1.0).poll() == refusal("a speed needs mode compensating or manual; the mode is standby")
    assert link.speeds == []


def test_a_speed_ends_with_a_refusal_when_the_controller_falls_silent():
    link = FakeLink()
    lowering = Lowering(link, 0.1, 1.0)
    assert lowering.poll() is None
    link.wall_time = 5.1
    assert lowering.poll().is_refused


def test_a_move_by_some_depth_begins_where_the_unit_hangs():
    link = FakeLink()
    move = MoveBy(link, -2.0, 0.3)
    assert move.poll() is None
    assert link.moves == []
    link.situation.depth = 300.0
    assert move.poll() is None
    assert link.moves == [(298.0, 0.3)]
    link.move.answer = Answer("arrived: mean depth 298.00 m")
    assert move.poll() == link.move.answer


def test_a_move_by_some_depth_is_refused_where_nobody_knows_the_depth():
    link = FakeLink()
    move = MoveBy(link, -2.0, 0.0)
    move.poll()
    link.wall_time = 5.1
    assert move.poll().is_refused


def test_a_move_that_nobody_waits_for_is_answered_once_it_is_under_way():
    move, shown = Given(), []
    followed = Followed(move, lambda *now: shown.append(now), waits=False)
    assert followed.poll() is None
    move.progress = (300.0, 0.1, 12.0)
    assert followed.poll() == Answer("under way from 300.00 m, 12 s to go")
    assert shown == [(300.0, 0.1, 12.0)]


def test_several_requests_are_answered_by_what_was_done():
    assert AnyOf([Given(Answer("a")), Given(refusal("b"))]).poll() == Answer("a")
    assert AnyOf([Given(refusal("a")), Given(refusal("b"))]).poll() == refusal("a; b")
    assert AnyOf([Given(Answer("a")), Given(None)]).poll() is None
