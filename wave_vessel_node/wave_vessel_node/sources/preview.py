"""A preview of the boom tip, as of waves measured up-wave or by radar: the same sea some time ahead, with an error."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from heave_node.interface.preview import HeavePreview
from heave_node.numerics.arrays import Array
from heave_node.numerics.randomness import random_stream

from wave_vessel_node.parameters import PreviewParameters
from wave_vessel_node.sources.motion_source import block_from


class PreviewSource:
    """Gives at each tick the heave of all ticks to come within its length.

    A moment is seen with the same error again and again: that of a measurement which was made once.

    Parameters
    ----------
    parameters : how far it looks, and how well
    heave_at : true heave of the boom tip at ticks [m], shape (n,); they are asked for in order, from 2
    seed : fixes the error
    tick_period : [s]
    """

    def __init__(
        self, parameters: PreviewParameters, heave_at: Callable[[range], Array], *, seed: int, tick_period: float
    ) -> None:
        self._heave_at, self._noise = heave_at, parameters.noise
        self._random = random_stream(seed, "preview")
        self._tick_nanoseconds = round(tick_period * 1e9)
        ticks = max(1, round(parameters.time / tick_period))
        self._ahead: Array = tick_period * np.arange(1, ticks + 1, dtype=float)
        self._first, self._heave = 2, np.zeros(0)

    def step(self, tick: int) -> HeavePreview:
        """Return the preview at t_k, for k = `tick`; ticks come in order, from 1."""
        end = tick + 1 + self._ahead.size
        while (known := self._first + self._heave.size) < end:
            fresh = self._heave_at(block_from(known))
            fresh = fresh + self._noise * self._random.standard_normal(fresh.size)
            self._heave = np.append(self._heave[tick + 1 - self._first :], fresh)
            self._first = tick + 1
        heave = self._heave[tick + 1 - self._first : end - self._first]
        return HeavePreview(self._ahead, heave, tick * self._tick_nanoseconds)
