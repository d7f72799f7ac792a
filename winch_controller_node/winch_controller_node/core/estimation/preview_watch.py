"""Whether a preview of the boom tip can be used: well-formed, recent, long enough, and proved by what came."""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from heave_node.interface.preview import HeavePreview

from winch_controller_node.laws.parts.preview import PreviewUse

MAXIMUM_AGE = 5.0
"""A preview older than this [s] is not used: what sent it has fallen silent."""
PROOF_TIME = 10.0
"""A preview is used once it has come true for so long [s]."""
LEAD = 1.0
"""Lead at which a preview is compared with what the MRU then read [s]."""
MEMORY = 30.0
"""Time over which error and heave are compared [s]."""
WORST_SHARE, WORST_NOISE = 0.5, 3.0
"""A preview is refused where its error is above this share of the heave, and above this many times its stated noise."""


class PreviewWatch:
    """Holds the newest preview and decides whether it is used.

    Parameters
    ----------
    use : what the law wants of it; None: it uses none
    tick_period : [s]
    """

    def __init__(self, use: PreviewUse | None, *, tick_period: float) -> None:
        self._use, self._dt = use, tick_period
        self._newest: HeavePreview | None = None
        # why the newest preview is not used, in words; empty where it is, where none has come or none is wanted
        self.fault = ""
        self.has_come = False  # one has come since the start
        lead_ticks = max(1, round(LEAD / tick_period))
        self._reported = deque([math.nan] * lead_ticks, maxlen=lead_ticks)
        self._lead = lead_ticks * tick_period
        self._compared = 0
        self._error_square = self._heave_square = 0.0

    @property
    def words(self) -> str:
        """How it is with the preview."""
        if self._use is None:
            return "not used: only law mpc with mpc.preview_time above 0 uses one"
        return f"not used: {self.fault}" if self.fault else "used"

    def is_wanted(self, delivered: HeavePreview | None) -> bool:
        """Tell whether a tick has to do with a preview: one was `delivered`, or the law uses one that came before."""
        return delivered is not None or (self._newest is not None and self._use is not None)

    def step(self, now: int, delivered: HeavePreview | None, boom_tip: float | None) -> HeavePreview | None:
        """Return the preview to be used at a tick, seen from it; None: none.

        Parameters
        ----------
        now : simulated time of the tick [ns]
        delivered : newest preview that came in this tick; None: none came
        boom_tip : its estimated heave now [m]; None: the motion reference unit is lost
        """
        if delivered is not None:
            self._newest, self.has_come = delivered, True
        if self._newest is None or self._use is None:
            return None
        seen, self.fault = _seen_from(now, self._newest, self._use)
        self._compare(seen, boom_tip)
        if seen is not None and not self.fault:
            self.fault = self._fault_of(self._use.noise)
        return None if self.fault else seen

    def _compare(self, seen: HeavePreview | None, boom_tip: float | None) -> None:
        """Compare what was predicted some time ago with what has come."""
        predicted_now = self._reported[0]
        reaches = seen is not None and seen.covers(self._lead, self._lead)
        self._reported.append(float(np.interp(self._lead, seen.ahead, seen.heave)) if seen and reaches else math.nan)
        if boom_tip is None or not math.isfinite(predicted_now):
            return
        self._compared += 1
        weight = max(self._dt / MEMORY, 1.0 / self._compared)
        self._error_square += weight * ((predicted_now - boom_tip) ** 2 - self._error_square)
        self._heave_square += weight * (boom_tip**2 - self._heave_square)

    def _fault_of(self, noise: float) -> str:
        """Return why a well-formed preview of a stated `noise` [m] is not used yet; empty where it is."""
        if self._compared * self._dt < PROOF_TIME:
            return f"compared with the motion for {PROOF_TIME:g} s before it is used"
        error, heave = math.sqrt(self._error_square), math.sqrt(self._heave_square)
        if error <= max(WORST_SHARE * heave, WORST_NOISE * noise):
            return ""
        return f"error {error:.2f} m rms at {LEAD:g} s ahead, in a heave of {heave:.2f} m rms"


def _seen_from(now: int, newest: HeavePreview, use: PreviewUse) -> tuple[HeavePreview | None, str]:
    """Return a preview as it is at a time, and what is wrong with it.

    Parameters
    ----------
    now : simulated time [ns]
    newest : preview that came last
    use : what the law wants of it
    """
    fault = _malformed(newest)
    if fault:
        return None, fault
    age = (now - newest.stamp) * 1e-9
    if age < 0.0:
        return None, f"its stamp is {-age:.3g} s ahead of the clock"
    if age > MAXIMUM_AGE:
        return None, f"no data for more than {MAXIMUM_AGE:g} s"
    seen = newest.seen_from(now)
    if not seen.covers(use.first, use.last):
        reported = f"{seen.ahead[0]:.3g} to {seen.ahead[-1]:.3g} s"
        return seen, f"it covers {reported} ahead; the law needs {use.first:g} to {use.last:g} s (mpc.preview_time)"
    return seen, ""


def _malformed(preview: HeavePreview) -> str:
    """Return what is wrong with the numbers of a `preview`; empty where nothing is."""
    ahead, heave = preview.ahead, preview.heave
    if len(ahead) != len(heave) or not len(ahead):
        return f"it has {len(ahead)} times and {len(heave)} heaves"
    if not (np.all(np.isfinite(ahead)) and np.all(np.isfinite(heave))):
        return "it holds numbers that are not finite"
    return "" if np.all(np.diff(ahead) > 0.0) else "its times do not increase"
