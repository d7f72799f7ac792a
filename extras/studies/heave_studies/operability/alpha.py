"""Alpha factors: by how much the forecast sea must stay below the limit, from the user's own table.

A CSV file: `hours` and design wave heights [m] in the first line, the planned duration [h] and its factors in each
further one. Between the values of the table factors are linear, beyond them those of its edge.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas
from heave_node.numerics.arrays import Array
from heave_node.parameters import ParameterError


@dataclass(frozen=True)
class AlphaTable:
    """Factors by planned duration and design wave height."""

    hours: Array  # planned durations, rising, shape (n,) [h]
    heights: Array  # design significant wave heights, rising, shape (m,) [m]
    factors: Array  # above 0, at most 1, shape (n, m)

    def factor(self, hours: float, heights: Array) -> Array:
        """Return the factor.

        Parameters
        ----------
        hours : planned duration [h]
        heights : design wave heights, any shape [m]
        """
        of_duration = np.array([np.interp(hours, self.hours, column) for column in self.factors.T])
        return np.asarray(np.interp(heights, self.heights, of_duration))


def read_alpha(path: Path) -> AlphaTable:
    """Read the table at `path`; raise ParameterError, in one line, for what is wrong with it."""
    try:
        table = pandas.read_csv(path, comment="#", skipinitialspace=True)
        heights = np.array([float(name) for name in table.columns[1:]])
        values = table.to_numpy(dtype=float)
    except OSError as error:
        raise ParameterError(f"{path}: cannot be read: {error.strerror}") from error
    except (ValueError, UnicodeDecodeError) as error:
        raise ParameterError(f"{path}: is not a table of hours by wave heights: {error}") from error
    hours, factors = values[:, 0], values[:, 1:]
    if not factors.size or (np.diff(hours) <= 0.0).any() or (np.diff(heights) <= 0.0).any():
        raise ParameterError(f"{path}: hours and wave heights must rise")
    if not ((factors > 0.0) & (factors <= 1.0)).all():
        raise ParameterError(f"{path}: alpha factors must be above 0 and at most 1")
    return AlphaTable(hours, heights, factors)
