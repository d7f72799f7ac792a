"""Readings of an adapter as messages of the suite, and messages of any installed type by name."""

from __future__ import annotations

import math
from typing import Any

from heave_bringup.errors import CommandError
from heave_msgs.msg import PointMotion, WinchState
from heave_node.interface.codes import WinchFault
from heave_node.interface.messages import message_type
from heave_node.tick.tick import stamp_of

from heave_devices.live.adapter import WinchReading
from heave_devices.live.winch_handshake import WinchHandshake, WinchOrder


def installed_type(name: str, where: str) -> type[Any]:
    """Return the message class of the type `name`. Raises CommandError, with its place `where`, if there is none."""
    try:
        package, kind, message = name.split("/")
        return message_type(f"{package}/{kind}/{message}")
    except (ValueError, ModuleNotFoundError, AttributeError, ImportError):
        raise CommandError(
            f"{where}: the message type {name or 'that is not given'} is not installed: build its package, source the "
            "workspace, and write it as PACKAGE/msg/TYPE"
        ) from None


def winch_state(reading: WinchReading, order: WinchOrder, handshake: WinchHandshake) -> WinchState:
    """Return the state of a drive: by its own `reading`, else by the last `order`; faults are the `handshake`'s."""
    rate = reading.payout_rate
    state = WinchState(command_sequence=order.sequence, encoder_payout=reading.payout, encoder_payout_rate=rate)
    state.header.stamp = stamp_of(reading.stamp)
    state.payout = state.payout_rate = state.payout_acceleration = math.nan
    state.tension = reading.tension
    state.power = -reading.tension * rate
    is_slow = not abs(rate) > 0.01
    state.brake = bool(reading.brake) if math.isfinite(reading.brake) else order.brake and is_slow
    if math.isfinite(reading.fault):
        handshake.latch.hold(WinchFault.DRIVE, "the drive reports a trip", is_present=reading.fault != 0.0)
    state.fault = int(handshake.fault)
    state.release = int(handshake.release(rate))
    return state


def boom_tip(stamp: Any, height: float, motion: tuple[float, float, float]) -> PointMotion:
    """Return where the simulated boom tip is at the tick of a `stamp`, by its `height` at rest above still water [m].

    Its `motion` is heave, rate and acceleration, positive up [m], [m/s], [m/s^2].
    """
    tip = PointMotion()
    tip.header.stamp = stamp
    tip.header.frame_id = "world"
    tip.position.z = height + motion[0]
    tip.velocity.z, tip.acceleration.z = motion[1], motion[2]
    return tip
