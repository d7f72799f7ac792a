"""A random sea as a sum of components: exact in its spectrum, and without a period.

The band is cut into cells; in each cell one component carries the cell's energy, at a frequency drawn from the
spectrum within the cell. So the variance is the target's in every realisation, the ensemble has exactly the target
spectrum, and as the frequencies have no common divisor the sea does not repeat. Phases are uniform. Deep water.
"""

from __future__ import annotations

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
    frequency: Array, anchor: ComplexArray, turn: ComplexArray, real: Array, imaginary: Array, out: Array
) -> None:
    """Sum Re(c e^{i omega t}) and its first two derivatives into out (3, outputs)."""
    for row in range(real.shape[0]):
        value = rate = acceleration = 0.0
        for n in range(frequency.size):
            z_real = anchor[n].real * turn[n].real - anchor[n].imag * turn[n].imag
            z_imag = anchor[n].real * turn[n].imag + anchor[n].imag * turn[n].real
            part = real[row, n] * z_real - imaginary[row, n] * z_imag
            value += part
            rate -= frequency[n] * (real[row, n] * z_imag + imaginary[row, n] * z_real)
            acceleration -= frequency[n] * frequency[n] * part
        out[0, row] = value
        out[1, row] = rate
        out[2, row] = acceleration


class HarmonicSum:
    """Re(sum of c_n e^{i omega_n t}) and its two derivatives at ticks, exact at any tick in any order.

    Phases are evaluated exactly every 64 ticks and turned by a table in between: a tick costs microseconds, and its
    values depend on its number only.

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
        self._real = np.ascontiguousarray(coefficients.real)
        self._imaginary = np.ascontiguousarray(coefficients.imag)
        self._period = period
        self._table = np.exp(1j * np.outer(np.arange(_BLOCK) * period, self._frequency))
        self._anchor_block = -1
        self._anchor = np.empty(0, dtype=complex)
        self._out = np.empty((3, coefficients.shape[0]))

    def at(self, tick: int) -> Array:
        """Return value, rate and acceleration at time tick * period, shape (3, outputs); valid until the next call."""
        block, rest = divmod(tick, _BLOCK)
        if block != self._anchor_block:
            self._anchor = np.exp(1j * self._frequency * (block * _BLOCK * self._period))
            self._anchor_block = block
        _evaluate(self._frequency, self._anchor, self._table[rest], self._real, self._imaginary, self._out)
        return self._out
