"""The own time of a device as one clock that only goes on: midnights passed, counters that wrap, dates by ZDA."""

from __future__ import annotations

from heave_devices.formats.sample import DAY, Sample, TimeBase

COUNTER_WRAP = 2.0**32 * 1e-3
"""A counter of milliseconds in 32 bits begins again after this time [s]."""

LATEST = 1e11
"""No time of a device is later, from whatever year it counts: from the year 1 it is 6.4e10 [s]."""


class DeviceTime:
    """Turns the times of a device's samples into nanoseconds of one clock.

    Parameters
    ----------
    counter_wrap : time after which its counter begins again [s]; infinity: never

    UTC of the day gets the date of the last ZDA, if one has come; without one it counts from the first midnight. The
    receiver estimates the offset to its own clock, so that the date need not be known.
    """

    def __init__(self, counter_wrap: float = COUNTER_WRAP) -> None:
        self._periods = {TimeBase.DAY: DAY, TimeBase.COUNTER: counter_wrap}
        self._midnight = 0.0
        self._newest: dict[TimeBase, float] = {}

    def nanoseconds(self, sample: Sample) -> int | None:
        """Return the time of a sample [ns], above 0; None where it has none, or none that can be."""
        if sample.time is None or not 0.0 <= sample.time < LATEST:
            return None
        if sample.time_base is TimeBase.UNIX:
            if sample.kind == "ZDA":
                self._set_date(sample.time)
            return max(1, round(sample.time * 1e9))
        return max(1, round(self._counted_on(sample.time_base, sample.time) * 1e9))

    def _counted_on(self, base: TimeBase, time: float) -> float:
        """Return a time that wraps, counted on: the turn that is nearest to the newest one."""
        period = self._periods[base]
        start = self._newest.get(base, self._midnight + time if base is TimeBase.DAY else time)
        origin = self._midnight if base is TimeBase.DAY else 0.0
        turns = round((start - origin - time) / period)
        self._newest[base] = origin + time + (turns * period if turns else 0.0)
        return self._newest[base]

    def _set_date(self, time: float) -> None:
        midnight = time - time % DAY
        if self._midnight == 0.0:
            self._midnight = midnight
            self._newest.pop(TimeBase.DAY, None)
