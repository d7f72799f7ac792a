"""Array types that all packages share."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""Real numbers, any shape; docstrings say which."""

ComplexArray = NDArray[np.complex128]
"""Complex numbers, any shape."""
