"""A preview of the boom tip: its heave some time ahead, as waves that were measured up-wave or by radar tell it."""

from __future__ import annotations

from dataclasses import dataclass

from heave_node.numerics.arrays import Array

_CLOSE = 1e-6  # s: times that differ by less are the same


@dataclass(frozen=True, slots=True, eq=False)
class HeavePreview:
    """Boom-tip heave ahead of a time, as in heave_msgs/HeavePreview."""

    ahead: Array  # times after the stamp, ascending [s], shape (m,)
    heave: Array  # about its mean, positive up [m], shape (m,)
    stamp: int = 0  # simulated time from which `ahead` counts [ns]

    def seen_from(self, now: int) -> HeavePreview:
        """Return the same motion with its times counted from another simulated time, `now` [ns]."""
        return HeavePreview(self.ahead - (now - self.stamp) * 1e-9, self.heave, now)

    def covers(self, first: float, last: float) -> bool:
        """Return whether it covers all times from `first` to `last` after its stamp [s]."""
        return bool(len(self.ahead) and self.ahead[0] <= first + _CLOSE and self.ahead[-1] >= last - _CLOSE)
