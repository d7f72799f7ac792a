"""Whether the encoder reads a wrong scale, or the other way, as winch and depth sensor tell.

The encoder is believed before all else in a running loop, and so is what it says of the winch. One that reads half of
the payout makes the loop harmful within seconds, and one that is turned over makes it unstable.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from winch_controller_node.estimation.depth_witness import Seen

CLEARLY = 3.0
"""What the depth sensor sees is so many standard deviations from what is read, where that is wrong."""

WRONG = 0.25
"""An encoder that is off by less is left to the comparison of all sensors: so may the gain of a winch well be."""

NEARER, ALIKE_SEEN = 0.35, 0.3
"""What winch and depth sensor see is nearer to each other than to the encoder, by the first factor at least, and no
farther from each other than the second, relatively.
"""
EXPLAINED = 0.1
"""What is left where a scale explains it, over all that it has to explain."""

AGREED, ALIKE = 3, 0.5
"""So many judgements in a row must say the same, relative to the last: one wave shows what a scale is not."""

JUDGED_PERIOD = 0.5
"""Time from one judgement to the next [s]."""

CONTRARY_TIME, CONTRARY_PERIOD = 0.8, 0.1
"""Time over which an encoder that goes the other way is seen, and time from one look to the next [s]: a loop that
believes it is unstable.
"""

CONTRARY, NOT_CONTRARY = -0.2, 0.5
"""It does where it reads so little of what the winch was sent, and does no more where it reads so much."""

STRAIGHT = 0.15
"""And where no more is left of its readings: a drum that is weak lags behind, and goes the other way for a moment."""

SUDDEN, NOT_SUDDEN = (0.6, 1.6), (0.75, 1.3)
"""One that has read what the winch was sent, and all at once reads less or more than so many times as much, makes the
loop harmful within seconds; it does no more where it reads as much as the second says.
"""

TRUE = 0.1
"""It reads what the winch was sent where it is off by no more: so does no winch that is weaker or slower than known."""

LEAST_SHARE = 1e-9
"""No share is taken for less where something is divided by it."""


class Sent(NamedTuple):
    """What the encoder reads of what the winch was sent.

    Attributes
    ----------
    share : times as much
    left : standard deviation of the rest over that of the readings
    payout : where it should be by now, did it start where it was read [m]
    """

    share: float
    left: float
    payout: float


class Scale(NamedTuple):
    """A scale that is wrong.

    Attributes
    ----------
    value : a reading over what it should be
    seen : what the depth sensor has seen of it
    """

    value: float
    seen: Seen


class ScaleJudge:
    """Says that a scale is wrong once that has been seen for some time.

    Attributes
    ----------
    doubts : it is seen now
    """

    def __init__(self) -> None:
        self.doubts = False
        self._agreed, self._last = 0, 0.0

    def judge(self, scale: Scale | None) -> Scale | None:
        """Take in the `scale` of a judgement, None where it may well be right; return it once it is sure."""
        self.doubts = scale is not None
        if scale is None:
            self._agreed = max(self._agreed - 1, 0)
            return None
        is_alike = abs(scale.value - self._last) < ALIKE * abs(scale.value)
        self._agreed, self._last = self._agreed + 1 if is_alike else 1, scale.value
        if self._agreed < AGREED:
            return None
        self._agreed, self.doubts = 0, False
        return scale


def is_off(sent: Sequence[Sent | None]) -> bool:
    """Tell whether the encoder reads anything else than the winch was `sent`, over any time."""
    return any(one is not None and abs(one.share - 1.0) > WRONG for one in sent)


def encoder_scale(sent: Sequence[Sent | None], seen: Sequence[Seen | None]) -> Scale | None:
    """Return the scale by which winch and depth sensor agree against the encoder; None: they do not.

    Parameters
    ----------
    sent, seen : what the encoder reads of what the winch was sent, and what is seen of that, over the same times
    """
    known, found = _known(sent, seen), []
    for one, other in known:
        off = abs(other.share - 1.0)
        is_alike = abs(one.share * other.share - 1.0) < min(NEARER * off, ALIKE_SEEN)
        if off > CLEARLY * other.sigma and is_alike:
            found.append(other)
    return _surest(known, found)


def winch_gain(sent: Sequence[Sent | None], seen: Sequence[Seen | None]) -> Scale | None:
    """Return by how much more the winch does than it was sent, as encoder and depth sensor agree; None: they do not.

    Parameters
    ----------
    sent, seen : as for `encoder_scale`
    """
    known, found = _known(sent, seen), []
    for one, other in known:
        off = abs(1.0 - one.share) / max(abs(one.share), LEAST_SHARE)
        if off > CLEARLY * other.sigma and abs(other.share - 1.0) < NEARER * off:
            found.append(other)
    return _surest(known, found)


def _known(sent: Sequence[Sent | None], seen: Sequence[Seen | None]) -> list[tuple[Sent, Seen]]:
    """Return what was `sent` and `seen` over the times in which a scale that is off explains what the encoder reads."""
    return [
        (one, other)
        for one, other in zip(sent, seen, strict=True)
        if one is not None and other is not None and abs(one.share - 1.0) > WRONG and one.left < EXPLAINED
    ]


def _surest(known: Sequence[tuple[Sent, Seen]], found: Sequence[Seen]) -> Scale | None:
    """Return the scale over that time of all `known` over which it explains most, as it is `found` with least doubt."""
    if not found:
        return None
    value = min(known, key=lambda pair: pair[0].left)[0].share
    return Scale(value, min(found, key=lambda seen: seen.sigma / max(abs(seen.share), LEAST_SHARE)))


def is_right_way(sent: Sent) -> bool:
    """Tell whether the encoder goes the way that the winch was `sent`."""
    return sent.share > NOT_CONTRARY and sent.left < STRAIGHT


def is_contrary(sent: Sent, *, was: bool) -> bool:
    """Tell whether an encoder goes the other way than the winch was `sent`, and if it `was` so, still does."""
    return sent.share < NOT_CONTRARY if was else sent.share < CONTRARY and sent.left < STRAIGHT


def is_true(sent: Sent) -> bool:
    """Tell whether the encoder reads what the winch was `sent`."""
    return abs(sent.share - 1.0) < TRUE and sent.left < STRAIGHT


def is_sudden(sent: Sent, *, was: bool) -> bool:
    """Tell whether an encoder reads far less or more than the winch was `sent`, and if it `was` so, still does."""
    least, most = NOT_SUDDEN if was else SUDDEN
    return not least < sent.share < most and (was or sent.left < STRAIGHT)
