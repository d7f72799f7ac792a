"""What the loop does, in a sentence of an alarm: by the mode that was decided in the tick of the alarm."""

from __future__ import annotations

from winch_controller_node.core.supervision.modes import Mode

LOOP_WORDS: dict[Mode, str] = {
    Mode.OFF: "AHC is off",
    Mode.STANDBY: "No compensation: winch in standby, brake on",
    Mode.COMPENSATING: "Compensation continues",
    Mode.CONSTANT_TENSION: "Constant tension continues",
    Mode.MANUAL: "Manual operation continues",
    Mode.FADE_OUT: "Compensation is fading out, then the winch stops",
    Mode.STOPPING: "Winch is stopping",
    Mode.STOPPED: "No compensation: winch stopped, brake on",
    Mode.EMERGENCY_STOP: "No compensation: emergency stop",
}
"""What follows for the load, by mode."""
DAMPED = "Compensation is fading out; the depth sensor damps the load"


def loop_words(mode: Mode, *, is_damped_blind: bool) -> str:
    """Return what the loop does in a `mode`; `is_damped_blind`: the load is damped by the depth sensor alone."""
    return DAMPED if mode is Mode.FADE_OUT and is_damped_blind else LOOP_WORDS[mode]
