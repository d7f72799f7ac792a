"""A real winch under test, by the map that `heave adapt` uses for it."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from heave_bringup.errors import CommandError
from heave_node.parameters import ParameterError

from heave_devices.adapt.device import LiveDevice
from heave_devices.adapt.report import stale_words
from heave_devices.adapt.session import Session
from heave_devices.bench.set_signal import Event
from heave_devices.bench.winch import PERIOD, Sample
from heave_devices.live.adapter import WINCH_STATE
from heave_devices.live.winch_handshake import WinchOrder
from heave_devices.maps.device_map import DeviceMap

READY = 8.0
"""A winch that has not reported its payout after this time is not there [s]."""


class RealPart:
    """A winch behind a map.

    Parameters
    ----------
    device : that is started
    spin : serves its topics for a time [s]
    ask : asks a person to do what an event says

    Raises CommandError where it reports nothing.
    """

    is_real = True

    def __init__(self, device: LiveDevice, spin: Callable[[float], None], ask: Callable[[Event], object]) -> None:
        self._device, self._spin, self._ask = device, spin, ask
        self._sequence = 0
        end = time.monotonic() + READY
        while "payout" not in device.adapter.newest:
            if time.monotonic() > end:
                raise CommandError(f"{device.device.name}: {words_of(device)}")
            spin(PERIOD)
            device.guard()

    def step(self, payout: float, rate: float, *, brake: bool) -> Sample:
        """See `WinchPart.step`."""
        self._sequence += 1
        self._device.command(WinchOrder(payout, rate, brake, self._sequence))
        self._spin(PERIOD)
        self._device.guard()
        return self._sample()

    def idle(self) -> Sample:
        """See `WinchPart.idle`; the device's own watchdog is not fed either."""
        self._spin(PERIOD)
        return self._sample()

    def strike(self, event: Event) -> None:
        """See `WinchPart.strike`: a person is asked to do it."""
        self._ask(event)

    def _sample(self) -> Sample:
        newest, watch, now = self._device.adapter.newest, self._device.adapter.watch, time.monotonic()
        fault = newest.get("fault", 0.0) or float(self._device.orders.handshake.fault)
        return Sample(
            now,
            newest.get("payout", math.nan),
            newest.get("payout_rate", math.nan),
            newest.get("brake", 0.0),
            fault,
            watch.age(now) if watch.is_stale(now) else 0.0,
        )


def ask(event: Event) -> None:
    """Tell the person at the winch on the terminal what to do for an `event`."""
    sys.stderr.write(f"\nheave: now: {event.ask or event.words}\n")


def words_of(device: LiveDevice, otherwise: str = "") -> str:
    """Return in words why a winch, `device`, does not move; `otherwise` where it is heard and has no problem."""
    now, newest, command = time.monotonic(), device.adapter.newest, device.device.command
    is_heard = not device.adapter.watch.is_stale(now)
    words = device.problem or (is_heard and otherwise) or stale_words(device, now)
    if is_heard and newest.get("fault") and command is not None and not command.counts:
        return f"{words}; the map sends it no watchdog: does it need one?"
    if is_heard and newest.get("fault"):
        return f"{words}; check its display, the map's fault, and where the map sends its watchdog"
    return f"{words}; check the map's brake, and enable in the command" if is_heard and newest.get("brake") else words


def is_winch(device: DeviceMap) -> bool:
    """Return whether a `device` is a winch that takes orders."""
    return WINCH_STATE in device.outputs and device.command is not None


@contextmanager
def real_winch(device: DeviceMap) -> Iterator[RealPart]:
    """Open the winch of a map, `device`, and close it at the end.

    Raises ParameterError where it is no winch, CommandError where it cannot be opened.
    """
    if not is_winch(device):
        raise ParameterError(f"{device.name}: is not the map of a winch, with payout and command")
    with Session([device]).one() as (live, spin):
        yield RealPart(live, spin, ask)
