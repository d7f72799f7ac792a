"""What the node says of itself in diagnostics."""

from types import SimpleNamespace

import pytest

pytest.importorskip("rclpy")
pytest.importorskip("heave_msgs")

from heave_node.ros.diagnostics import Level
from winch_controller_node.node import WinchControllerNode


def health_of(mode, *, is_inhibited, reason=""):
    """Return level and words of the mode, as `diagnose` says them."""
    report = SimpleNamespace(
        mode=mode, is_inhibited=is_inhibited, reason=reason, authority=0.0, sensors=(), solver_status="free"
    )
    node = SimpleNamespace(
        outputs_of_tick=SimpleNamespace(report=report),
        controller=SimpleNamespace(depth=300.0, preview=SimpleNamespace(has_come=False)),
        _changes={},
        _told={},
        _diagnose_commands=lambda: None,
    )
    part = WinchControllerNode.diagnose(node)[0]
    return part.level, part.message


@pytest.mark.parametrize(
    ("mode", "is_inhibited", "level"),
    [
        ("standby", False, Level.OK),
        ("standby", True, Level.ERROR),
        ("compensating", False, Level.OK),
        ("fade_out", False, Level.WARN),
        ("fade_out", True, Level.ERROR),
        ("stopped", False, Level.ERROR),
    ],
)
def test_standing_by_is_an_error_where_the_guard_keeps_compensation_off(mode, is_inhibited, level):
    found, words = health_of(mode, is_inhibited=is_inhibited, reason="the unit swings more than off")
    assert found == level
    assert words == f"{mode}: the unit swings more than off"
