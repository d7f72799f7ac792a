"""Innovations of the estimator, and whether they are consistent."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from heave_node.numerics.arrays import Array

from heave_bags.analyse.reading.fields import Fields
from heave_bags.signals import Signal

NIS_BAND = (0.000982069, 5.02388619)
"""Central 95 % of the chi-square distribution with one degree of freedom."""


@dataclass
class Innovation:
    """Innovations of one measurement, its `name`."""

    name: str  # of the measurement
    time: Array  # shape (n,) [s]
    value: Array  # innovation, shape (n,), in the unit of the measurement
    sigma: Array  # its predicted standard deviation, shape (n,), in the same unit


def innovations(state: Fields) -> list[Innovation]:
    """Return the innovations of each measurement from the columns of the controller's `state`."""
    values, sigmas = state.table("innovation"), state.table("innovation_sigma")
    if values is None or sigmas is None:
        return []
    found = []
    for column in range(min(values.shape[1], sigmas.shape[1])):
        names = state.texts(f"measurement_names[{column}]")
        given = [name for name in names if name] if names is not None else []
        good = np.isfinite(values[:, column])
        if good.any():
            name = str(given[0]) if given else f"measurement {column + 1}"
            found.append(Innovation(name, state.time[good], values[good, column], sigmas[good, column]))
    return found


def nis_in_band(state: Fields) -> Signal:
    """Return whether each normalised innovation squared in the controller's `state` is in its 95 % band."""
    nis = state.table("nis")
    if nis is None or not nis.size:
        return Signal()
    finite = np.isfinite(nis)
    inside = (nis >= NIS_BAND[0]) & (nis <= NIS_BAND[1])
    rows = np.repeat(state.time[:, None], nis.shape[1], axis=1)
    return Signal(rows[finite], inside[finite].astype(float))
