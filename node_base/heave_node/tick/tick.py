"""A tick of the run: its number and its times. Time is counted in whole nanoseconds: rounding does not add up."""

from __future__ import annotations

from dataclasses import dataclass

from builtin_interfaces.msg import Time


def stamp_of(nanoseconds: int) -> Time:
    """Return simulated time in `nanoseconds` as a message stamp."""
    seconds, rest = divmod(nanoseconds, 1_000_000_000)
    return Time(sec=seconds, nanosec=rest)


def nanoseconds_of(stamp: Time) -> int:
    """Return a message `stamp` as simulated time [ns]."""
    return stamp.sec * 1_000_000_000 + stamp.nanosec  # type: ignore[no-any-return]


def seconds_of(stamp: Time) -> float:
    """Return a message `stamp` as simulated time [s]."""
    return nanoseconds_of(stamp) * 1e-9


def stamp_of_seconds(seconds: float) -> Time:
    """Return simulated time in `seconds` as a message stamp, to the nearest nanosecond."""
    return stamp_of(round(seconds * 1e9))


@dataclass(frozen=True)
class Tick:
    """Tick `number` of run `epoch`: from t_k = k * period to t_{k+1}."""

    number: int  # k, from 1
    epoch: int  # number of the run since the master started; a reset makes a new one
    period_nanoseconds: int  # length of a tick [ns]

    @property
    def start_nanoseconds(self) -> int:
        """t_k [ns]."""
        return self.number * self.period_nanoseconds

    @property
    def time(self) -> float:
        """t_k [s]."""
        return self.start_nanoseconds * 1e-9

    @property
    def stamp(self) -> Time:
        """t_k as a stamp."""
        return stamp_of(self.start_nanoseconds)

    @property
    def end_nanoseconds(self) -> int:
        """t_{k+1} [ns]."""
        return self.start_nanoseconds + self.period_nanoseconds

    @property
    def end_stamp(self) -> Time:
        """t_{k+1} as a stamp."""
        return stamp_of(self.end_nanoseconds)
