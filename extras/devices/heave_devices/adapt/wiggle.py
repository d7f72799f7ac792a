"""`heave adapt MAP --wiggle MM`: the move of millimetres, on a live winch."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

from heave_bringup.errors import CommandError
from heave_node.parameters import ParameterError

from heave_devices.adapt.device import LiveDevice
from heave_devices.adapt.report import stale_words
from heave_devices.live.adapter import WINCH_STATE
from heave_devices.live.wiggle import (
    DURATION,
    LARGEST,
    LEAST,
    Reading,
    Verdict,
    is_too_far,
    judge,
    move_at,
    reset_verdict,
)
from heave_devices.live.winch_handshake import WinchOrder
from heave_devices.maps.device_map import DeviceMap

_PERIOD = 0.05
_READY_TIME = 8.0
"""A winch that has not spoken, or not released its brake, after this time does neither [s]."""


def check_wiggle(maps: list[DeviceMap], distance: float) -> None:
    """Raise CommandError where `maps` are not one winch, or the `distance` [m] is none of a wiggle."""
    if len(maps) != 1 or WINCH_STATE not in maps[0].outputs or maps[0].command is None:
        raise ParameterError("--wiggle: name the map of one winch, with payout and command")
    if not LEAST <= distance <= LARGEST:
        raise ParameterError(f"--wiggle {1e3 * distance:g}: must be from {1e3 * LEAST:g} to {1e3 * LARGEST:g} mm")


class Wiggle:
    """Moves one winch.

    Parameters
    ----------
    device : the winch
    spin : serves the topics of ROS for a time [s]
    distance : of the move [m]
    """

    def __init__(self, device: LiveDevice, spin: Callable[[float], None], distance: float) -> None:
        self._device = device
        self._spin = spin
        self._distance = distance
        self._sequence = 0
        self._readings: list[Reading] = []

    def run(self) -> list[Verdict]:
        """Move out and back; return what was found. The winch is braked at the end, whatever comes.

        Raises CommandError where it does not speak, keeps its brake on, or runs away.
        """
        try:
            self._until(lambda: math.isfinite(self._payout))
            was_tripped = bool(self._device.adapter.newest.get("fault", 0.0))
            self._until(lambda: not self._device.is_held, is_release=True)
            self._move()
        finally:
            self._command(0.0, 0.0, brake=True)
            self._spin(2.0 * _PERIOD)
        command = self._device.device.command
        resets = command is not None and any(order.quantity == "reset" for order in command.orders)
        reset = [reset_verdict(was_tripped=was_tripped)] if resets else []
        return judge(self._readings, self._distance) + reset

    @property
    def _payout(self) -> float:
        return self._device.adapter.newest.get("payout", math.nan)

    def _command(self, moved: float, rate: float, *, brake: bool) -> None:
        self._sequence += 1
        start = self._readings[0].payout if self._readings else self._device.adapter.newest.get("payout", 0.0)
        self._device.command(WinchOrder(start + moved, rate, brake, self._sequence))

    def _until(self, is_reached: Callable[[], bool], *, is_release: bool = False) -> None:
        """Command the brake on, and for a release then off, until the winch has done so."""
        end = time.monotonic() + _READY_TIME
        began = time.monotonic()
        while not is_reached() or (is_release and time.monotonic() - began < 1.0):
            if time.monotonic() > end:
                is_heard = not self._device.problem and not self._device.adapter.watch.is_stale(time.monotonic())
                words = "its brake stays on" if is_release and is_heard else self._device_words()
                raise CommandError(f"{self._device.device.name}: {words}")
            is_off = is_release and time.monotonic() - began >= 1.0
            self._command(0.0, 0.0, brake=not is_off)
            self._serve()

    def _device_words(self) -> str:
        return self._device.problem or stale_words(self._device, time.monotonic())

    def _serve(self) -> None:
        self._spin(_PERIOD)
        self._device.guard()

    def _move(self) -> None:
        began = time.monotonic()
        start = self._payout
        while (elapsed := time.monotonic() - began) < DURATION:
            newest = self._device.adapter.newest
            self._readings.append(Reading(elapsed, self._payout, newest.get("payout_rate", math.nan)))
            moved, rate = move_at(elapsed, self._distance)
            self._command(moved, rate, brake=False)
            self._serve()
            if self._device.is_held:
                raise CommandError(f"{self._device.device.name}: stopped by itself: {self._device_words()}")
            if is_too_far(self._payout, start, self._distance):
                moved = 1e3 * (self._payout - start)
                raise CommandError(
                    f"{self._device.device.name}: braked: {moved:+.1f} mm read, {1e3 * self._distance:.1f} mm wanted. "
                    "Check unit and scale, in the quantity and in the command"
                )
