"""What the keys of the screen do, and what they ask first."""

import pytest
from heave_bringup.operate.keys import BY_KEY, COMMANDS, EMERGENCY, QUIT, Keyboard

from bringup.test.operate_fakes import FakeLink


def keyboard():
    link, begun = FakeLink(), []
    return Keyboard(link, lambda name, task: begun.append(name)), link, begun


def press(board, keys):
    for key in keys:
        board.press(key)


@pytest.mark.parametrize("before", ["", "d", "d12", "c", "imru,free", "d12\r"])
def test_the_emergency_stop_is_one_key_whatever_is_being_asked(before):
    board, link, begun = keyboard()
    press(board, before)
    board.press(EMERGENCY)
    assert begun == ["EMERGENCY STOP"]
    assert [request.message.mode for request in link.requests] == ["emergency_stop"]
    assert board.prompt == ""


@pytest.mark.parametrize("key", ["c", "b", "t", "m", "r"])
def test_what_moves_the_winch_is_confirmed(key):
    board, link, begun = keyboard()
    board.press(key)
    assert board.prompt.endswith("sure? (y: yes, any other key: no)")
    assert link.requests == []
    board.press("n")
    assert (link.requests, board.prompt) == ([], "")
    press(board, [key, "y"])
    assert begun == [BY_KEY[key].name]


def test_a_depth_is_typed_corrected_and_confirmed():
    board, link, _ = keyboard()
    press(board, "d29x\x7f5\ry")
    assert link.moves == [(295.0, 0.0)]


def test_what_is_no_number_is_refused_in_words():
    board, link, begun = keyboard()
    press(board, "ftwo\r")
    assert (board.complaint, begun) == ("'two' is no number", [])
    press(board, "f2\r")
    assert board.complaint == "2: must be from 0 to 1"
    press(board, "dnan\ry")
    assert link.moves == []
    press(board, "iwhale,freeze\r")
    assert board.complaint.startswith("'whale' is no device; devices are mru,")


def test_a_fault_is_typed_with_commas():
    board, link, _ = keyboard()
    press(board, "iwinch,drive\ry")
    press(board, "imru,jump,10,0.5\ry")
    first, second = (request.message for request in link.requests)
    assert (first.device, first.kind, first.duration, first.magnitude) == ("winch", "drive", 0.0, 0.0)
    assert (second.device, second.kind, second.duration, second.magnitude) == ("mru", "jump", 10.0, 0.5)
    assert [request.service for request in link.requests] == ["virtual_winch/inject_fault", "wave_vessel/inject_fault"]


def test_escape_leaves_what_was_asked_and_q_the_screen():
    board, link, begun = keyboard()
    press(board, "d12\x1b")
    assert (board.prompt, begun, link.moves, board.is_left) == ("", [], [], False)
    board.press(QUIT)
    assert board.is_left


def test_no_two_commands_share_a_key_and_none_takes_the_emergency_stop():
    keys = [command.key for command in COMMANDS]
    assert len(set(keys)) == len(keys)
    assert not {EMERGENCY, QUIT, "y"} & set(keys)


@pytest.mark.parametrize(("typed", "said"), [("dxy\n", "'xy' is no number"), ("imru,blue\n", "'blue' is no kind")])
def test_what_is_typed_wrongly_is_refused_before_anybody_asks_whether_it_is_meant(typed, said):
    board, link, begun = keyboard()
    press(board, typed)
    assert said in board.complaint
    assert (board.prompt, begun, link.moves) == ("", [], [])


def test_faults_are_injected_into_and_cleared_from_what_is_simulated_alone():
    board, link, _ = keyboard()
    link.situation.simulated = ("mru", "depth")
    press(board, "iwinch,drive\ny")
    assert board.complaint == "winch is not simulated in this run; what is: mru, depth"
    press(board, "x")
    assert link.asked == ["wave_vessel/inject_fault", "cable_sim/inject_fault"]
    link.situation.simulated = ()
    press(board, "x")
    assert "nothing is simulated" in board.complaint
