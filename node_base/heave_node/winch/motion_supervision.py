"""Whether a drum does what it is ordered: what the supervision of a drive stops it for, whatever its controller thinks.

Rules, each for longer than the supervision's time, so that delay and lag of a sound drive do not count:

- it turns against the order;
- it stands while it is ordered to move;
- it does not slow down while it is ordered to brake;
- its brake does not open, or does not engage, as the brake's switch says.

Two more hold at once: it has moved by 0.05 m with its brake engaged, or since it stood while it is ordered to brake;
it has gone much further than it was ordered to, or the other way (`travel`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from heave_node.winch.travel import OrderedTravel

ORDERED = 0.05
"""An ordered speed of less is no order to move [m/s]."""
STANDING = 0.01
"""A drum slower than this stands [m/s]."""
SLOW = 0.1
"""A drum that is to brake is held by its brake below this speed [m/s]."""
SLIPPED = 0.05
"""A drum that has moved so far with its brake engaged slips [m]."""
UNSEEN = 1.0
"""A drum that is first found so far away was not seen to slip [m]: nobody looked, or its count is another one."""


class DrumReading(NamedTuple):
    """What a drum is ordered and what it does."""

    ordered_rate: float  # of the drum [m/s]
    is_braked: bool  # it is ordered to brake
    payout: float  # measured [m]; NaN: not known
    payout_rate: float  # measured [m/s]; NaN: not known
    brake: float  # other than 0 [-]: its switch says engaged; NaN: there is none


class MotionSupervision:
    """Supervises one drum.

    Parameters
    ----------
    time : for which a rule must be broken [s]; 0: no supervision

    Attributes
    ----------
    found : what was found last, in words; "": nothing yet
    is_slipping : that was a drum which its brake was to hold
    """

    def __init__(self, time: float) -> None:
        self._time = time
        self.found, self.is_slipping = "", False
        self._since: dict[str, float] = {}
        self._held_at = math.nan
        self._slowest = math.inf
        self._travel = OrderedTravel(time)

    def look(self, now: float, drum: DrumReading) -> str:
        """Return what is wrong with the `drum` at `now` [s], in words; "": nothing. What lasts is returned again."""
        if not self._time:
            return ""
        late, broken = "", self._broken(drum)
        self._slowest = min(self._slowest, abs(drum.payout_rate)) if drum.is_braked else math.inf
        self._since = {words: self._since.get(words, now) for words in broken} if broken else {}
        if broken and (late := next((words for words in broken if now - self._since[words] > self._time), "")):
            self._since.pop(late)
        slip = self._slip(drum)
        found = late or slip or self._far(now, drum)
        if found:
            self.found, self.is_slipping = found, drum.is_braked
        return found

    def _far(self, now: float, drum: DrumReading) -> str:
        if drum.is_braked or not math.isfinite(drum.payout):
            self._travel.restart()
            return ""
        return self._travel.look(now, drum.payout, drum.ordered_rate)

    def _broken(self, drum: DrumReading) -> list[str]:
        speed = math.copysign(1.0, drum.ordered_rate) * drum.payout_rate
        is_ordered = not drum.is_braked and abs(drum.ordered_rate) > ORDERED
        stands = abs(drum.payout_rate) < STANDING
        rules = {
            "the drum turns against the command": is_ordered and speed < -STANDING,
            "the drum stands against the command": is_ordered and stands,
            "the brake does not open": not drum.is_braked and math.isfinite(drum.brake) and bool(drum.brake),
            "the brake does not engage": drum.is_braked and abs(drum.payout_rate) < SLOW and drum.brake == 0.0,
            "the drum does not stop": drum.is_braked and abs(drum.payout_rate) >= max(SLOW, self._slowest),
        }
        return [words for words, is_broken in rules.items() if is_broken]

    def _slip(self, drum: DrumReading) -> str:
        is_engaged = drum.brake != 0.0 if math.isfinite(drum.brake) else abs(drum.payout_rate) < SLOW
        is_held = drum.is_braked and (is_engaged or self._slowest < STANDING)
        if not is_held or not math.isfinite(drum.payout):
            self._held_at = math.nan
            return ""
        if not math.isfinite(self._held_at):
            self._held_at = drum.payout
        moved = drum.payout - self._held_at
        if abs(moved) <= SLIPPED:
            return ""
        self._held_at = drum.payout
        if abs(moved) > UNSEEN:
            return f"the drum reads {moved:+.2f} m from where it was held: it moved unseen, or its count was lost"
        failed = "engage" if drum.brake == 0.0 else "hold"
        return f"the brake does not {failed}: the drum has moved by {moved:+.2f} m"
