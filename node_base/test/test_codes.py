"""The numbers of `heave_node.interface.codes` are those of the messages, which are the contract."""

import enum

import pytest
from heave_msgs.msg import MruSample, SensorHealth, WinchState
from heave_node.interface.codes import MruStatus, SensorLevel, WinchFault, WinchLimit, WinchRelease, fault_words


@pytest.mark.parametrize(
    ("codes", "message", "prefix"),
    [
        (WinchFault, WinchState, "FAULT_"),
        (WinchLimit, WinchState, "LIMIT_"),
        (WinchRelease, WinchState, "RELEASE_"),
        (MruStatus, MruSample, "STATUS_"),
        (SensorLevel, SensorHealth, ""),
    ],
)
def test_codes_and_message_constants_have_the_same_names_and_numbers(
    codes: type[enum.IntEnum], message: type, prefix: str
) -> None:
    constants = {
        name.removeprefix(prefix): getattr(message, name)
        for name in dir(message)
        if name.isupper() and name.startswith(prefix) and name != "SLOT_TYPES"
    }
    named = {code.name: code.value for code in codes}
    assert constants == named


def test_a_fault_is_told_in_words_also_one_that_hardware_made_up() -> None:
    assert fault_words(WinchState.FAULT_EMERGENCY_STOP) == "emergency stop"
    assert fault_words(9) == "unknown fault 9"
