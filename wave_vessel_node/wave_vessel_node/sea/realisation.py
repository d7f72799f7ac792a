"""A random sea as a sum of components: exact in its spectrum, and without a period.

The band is cut into cells; in each cell one component carries the cell's energy, at a frequency drawn from the
spectrum within the cell. So the variance is the target's in every realisation, the ensemble has exactly the target
spectrum, and as the frequencies have no common divisor the sea does not repeat. Phases are uniform. Deep water.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass

import numpy as np
from heave_node.numerics.arrays import Array, ComplexArray
from heave_node.numerics.compiled import kernel
from heave_node.numerics.constants import STANDARD_GRAVITY
from numpy.typing import ArrayLike

from wave_vessel_node.sea.spectra import SpectrumError, WaveSpectrum, cell_integrals

_TAIL_ENERGY = 1e-4  # of m_0, above the highest frequency drawn; it is carried by the topmost component
_BLOCK = 64  # ticks between two exact evaluations of the phases


@dataclass(frozen=True)
class WaveComponents:
    """Long-crested components: elevation at (x, y) is the sum of a cos(omega t - k (x cos d + y sin d) + phase)."""

    frequency: Array  # omega [rad/s], shape (n,), rising
    amplitude: Array  # a [m], shape (n,)
    phase: Array  # [rad], shape (n,)
    direction: Array  # d that the component travels to, from world x, anticlockwise [rad], shape (n,)

    @property
    def wave_number(self) -> Array:
        """K = omega^2 / g [1/m], deep water."""
        return self.frequency**2 / STANDARD_GRAVITY


def draw_components(
    spectrum: WaveSpectrum,
    count: int,
    generator: np.random.Generator,
    *,
    direction: float = 0.0,
    spreading_exponent: float = 0.0,
) -> WaveComponents:
    """Draw the components of a sea.

    Parameters
    ----------
    spectrum : of the sea
    count : of components; fewer are drawn where the spectrum has gaps
    generator : of frequencies, phases and directions
    direction : mean direction of travel [rad]
    spreading_exponent : s of D(angle) ~ cos^{2s}(angle / 2); 0 means long-crested. Each component gets one direction,
        drawn in strata, so that the sea stays ergodic
    """
    grid = spectrum.edges
    energy = cell_integrals(spectrum.density, grid)
    cumulative = np.concatenate(([0.0], np.cumsum(energy)))
    total = cumulative[-1]
    if total <= 0.0:
        frequency = np.linspace(0.5, 1.5, count) * spectrum.peak_frequency
        return WaveComponents(frequency, np.zeros(count), np.zeros(count), np.full(count, direction))
    edges = _cell_edges(grid, cumulative / total, count)
    at_edges = np.interp(edges, grid, cumulative)
    at_edges[0], at_edges[-1] = 0.0, total
    cell_energy = np.diff(at_edges)
    top = np.interp((1.0 - _TAIL_ENERGY) * total, cumulative, grid)
    drawn = at_edges[:-1] + cell_energy * generator.random(count)
    frequency = np.minimum(np.interp(drawn, cumulative, grid), top)
    phase = 2.0 * np.pi * generator.random(count)
    angle = _draw_spreading(spreading_exponent, count, generator)
    full = cell_energy > 0.0  # a measured spectrum may have gaps: cells there carry nothing
    amplitude = np.sqrt(2.0 * cell_energy[full])
    return WaveComponents(frequency[full], amplitude, phase[full], direction + angle[full])


def _cell_edges(grid: Array, fraction: Array, count: int) -> Array:
    """Cut the band in `count` cells: half the cells by equal energy, half by equal width, so that neither peak nor
    tail is coarse.
    """
    low, high = np.interp([1e-9, 1.0 - _TAIL_ENERGY], fraction, grid)
    mixed = 0.5 * fraction + 0.5 * np.clip((grid - low) / (high - low), 0.0, 1.0)
    edges = np.interp(np.linspace(0.0, mixed[-1], count + 1), mixed, grid)
    edges[0], edges[-1] = grid[0], grid[-1]
    return edges


def _draw_spreading(exponent: float, count: int, generator: np.random.Generator) -> Array:
    if exponent <= 0.0:
        return np.zeros(count)
    angle = np.linspace(-np.pi, np.pi, 7201)
    cumulative = np.concatenate(([0.0], np.cumsum(np.cos(0.25 * (angle[1:] + angle[:-1])) ** (2.0 * exponent))))
    quantile = (generator.permutation(count) + generator.random(count)) / count
    return np.interp(quantile, cumulative / cumulative[-1], angle)


@kernel
def _evaluate(
    frequency: Array,
    anchors: ComplexArray,
    table: tuple[Array, Array],
    first: int,
    weights: tuple[Array, Array],
    out: Array,
) -> None:
    """Add Re(c e^{i omega t}) and its two derivatives to out (3, outputs, ticks), from tick `first` of a block on.

    Each block has its row of anchors. Ticks are the innermost loop, so that they run side by side; the sum of each is
    in the order of the components.
    """
    turn_real, turn_imaginary = table
    real, imaginary = weights
    done = 0
    for anchor in anchors:
        count = min(turn_real.shape[1] - first, out.shape[2] - done)
        for row in range(real.shape[0]):
            value, rate, acceleration = out[0, row, done:], out[1, row, done:], out[2, row, done:]
            for n in range(frequency.size):
                omega, a, b = frequency[n], anchor[n].real, anchor[n].imag
                for t in range(count):
                    z_real = a * turn_real[n, first + t] - b * turn_imaginary[n, first + t]
                    z_imag = a * turn_imaginary[n, first + t] + b * turn_real[n, first + t]
                    part = real[row, n] * z_real - imaginary[row, n] * z_imag
                    value[t] += part
                    rate[t] -= omega * (real[row, n] * z_imag + imaginary[row, n] * z_real)
                    acceleration[t] -= omega * omega * part
        done, first = done + count, 0


class HarmonicSum:
    """Re(sum of c_n e^{i omega_n t}) and its two derivatives at ticks, exact at any ticks in any order.

    Phases are evaluated exactly every 64 ticks and turned by a table in between: a tick costs less than a microsecond,
    and its values depend on its number only.

    Parameters
    ----------
    frequency : [rad/s], shape (n,)
    coefficients : c, shape (outputs, n)
    period : tick period [s]
    """

    def __init__(self, frequency: ArrayLike, coefficients: ArrayLike, period: float) -> None:
        self._frequency = np.ascontiguousarray(frequency, dtype=float)
        coefficients = np.atleast_2d(np.asarray(coefficients, dtype=complex))
        if coefficients.shape[1] != self._frequency.size:
            raise SpectrumError(f"coefficients {coefficients.shape} do not match {self._frequency.size} frequencies")
        self._weights = np.ascontiguousarray(coefficients.real), np.ascontiguousarray(coefficients.imag)
        self._period = period
        turns = np.exp(1j * np.outer(np.arange(_BLOCK) * period, self._frequency)).T
        self._table = np.ascontiguousarray(turns.real), np.ascontiguousarray(turns.imag)

    def combined(self, matrix: Array) -> HarmonicSum:
        """Return the sum of which each output is a linear one of these: `matrix` of shape (its outputs, outputs)."""
        other = copy(self)
        real, imaginary = self._weights
        other._weights = np.ascontiguousarray(matrix @ real), np.ascontiguousarray(matrix @ imaginary)
        return other

    def at(self, ticks: range) -> Array:
        """Return value, rate and acceleration at the times of `ticks`, shape (ticks, 3, outputs)."""
        blocks = np.arange(ticks[0] // _BLOCK, ticks[-1] // _BLOCK + 1)
        anchors = np.exp(1j * self._frequency * (blocks * _BLOCK * self._period)[:, None])
        found = np.zeros((3, len(self._weights[0]), len(ticks)))
        _evaluate(self._frequency, anchors, self._table, ticks[0] % _BLOCK, self._weights, found)
        return found.transpose(2, 0, 1)
