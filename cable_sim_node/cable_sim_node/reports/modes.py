"""How unit and cable heave by themselves: natural periods, mode shapes, and the lengths at which a sea meets them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from heave_node.numerics.arrays import Array
from scipy.optimize import brentq

from cable_sim_node.errors import LinearisationError, StaticsError
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.parameters import CableSimParameters, SeabedParameters
from cable_sim_node.physics.seabed import clearance_of
from cable_sim_node.physics.tension_law import overstrained_words
from cable_sim_node.reports.report import columns, labelled_rows
from cable_sim_node.vertical.axial_line import AxialLine, axial_line
from cable_sim_node.vertical.linear import ResonanceMap, mode_shape, natural_frequencies, resonance_map, resonant_length

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SHORTEST_SHARE = 0.05
MAP_LENGTHS, MAP_PERIODS = 40, 120
"""The resonance map reaches from SHORTEST_SHARE of the longest length to all of it, in this many steps."""

LONGEST_PERIOD = 25.0
SHORTEST_PERIOD = 2.0
"""Range of periods of the map [s]: waves and swell."""


@dataclass(frozen=True)
class HeaveMode:
    """A mode of vertical motion with the boom tip held, undamped."""

    period: float  # [s]
    labels: Array  # unstretched length from the unit [m]
    shape: Array  # heave there, largest 1


@dataclass(frozen=True)
class ModesReport:
    """Free and forced small motion of unit and cable."""

    length: float  # of cable out [m]
    amplitude: float  # of the boom tip, for which drag is linearised [m]
    sea_period: float  # at which the sea is evaluated [s]
    heave: tuple[HeaveMode, ...]  # modes of the exact axial bar
    resonances: ResonanceMap  # motion of the unit over that of the boom tip, over length and frequency
    natural_periods: Array  # of the first heave mode at the lengths of `resonances` [s]
    critical_length: float | None  # length at which the first heave mode has `sea_period` [m]; None outside the map
    critical_estimate: float  # the same by EA/(w^2 (M + Ma)) (thesis 3.3.5) [m]
    left_out: tuple[str, ...] = ()  # parameters that are set and have no part in the modes

    def values(self) -> dict[str, object]:
        """Return the numbers with units in their names, for a machine."""
        return {
            "length_m": self.length,
            "amplitude_m": self.amplitude,
            "sea_period_s": self.sea_period,
            "heave_periods_s": [mode.period for mode in self.heave],
            "resonance": [
                {"length_m": float(length), "natural_period_s": float(period)}
                for length, period in zip(self.resonances.lengths, self.natural_periods, strict=True)
            ],
            "critical_length_m": self.critical_length,
            "critical_length_estimate_m": self.critical_estimate,
            "left_out": list(self.left_out),
        }

    def table(self) -> str:
        """Return the report as text for a person."""
        where = "none on the map" if self.critical_length is None else f"{self.critical_length:.1f} m"
        rows = [
            ("cable out", f"{self.length:g} m"),
            ("boom-tip amplitude for linear drag", f"{self.amplitude:g} m"),
            (f"length in resonance with {self.sea_period:.4g} s", where),
            ("estimate EA/(w^2 (M + Ma))", f"{self.critical_estimate:.1f} m"),
        ]
        heave = columns(
            ("heave mode", "period s"), [(f"{i + 1}", f"{mode.period:.4g}") for i, mode in enumerate(self.heave)]
        )
        note = f"\n\nnot in the modes: {'; '.join(self.left_out)}" if self.left_out else ""
        return f"{labelled_rows(rows)}\n\n{heave}{note}"

    def draw(self, figure: Figure) -> None:
        """Draw the mode shapes, and how the unit answers over period and length, into `figure`."""
        shapes, answers = figure.subplots(1, 2, width_ratios=(1, 2))
        for mode in self.heave:
            shapes.plot(mode.shape, mode.labels, label=f"{mode.period:.3g} s")
        shapes.set(xlabel="displacement, largest 1", ylabel="cable from the unit [m]", title="heave modes")
        shapes.grid(alpha=0.3)
        shapes.legend(fontsize="x-small")
        self._draw_map(figure, answers)

    def _draw_map(self, figure: Figure, axis: Axes) -> None:
        periods = 2.0 * math.pi / self.resonances.omegas
        answer = np.log10(np.maximum(self.resonances.unit_heave.T, 1e-3))
        colours = axis.pcolormesh(
            *(self.resonances.lengths, periods, answer), vmin=-1.0, vmax=1.0, shading="nearest", rasterized=True
        )
        axis.plot(self.resonances.lengths, self.natural_periods, "w-", label="natural period")
        axis.axhline(self.sea_period, color="w", linestyle=":", label=f"{self.sea_period:.4g} s")
        axis.axvline(self.length, color="w", linestyle="--", label=f"{self.length:g} m")
        axis.set(xlabel="cable out [m]", ylabel="period [s]", title="unit heave over boom-tip heave")
        axis.set_ylim(SHORTEST_PERIOD, LONGEST_PERIOD)
        axis.legend(loc="lower right", fontsize="x-small", facecolor="0.3", labelcolor="w")
        figure.colorbar(colours, ax=axis, label="log10")


def modes_report(
    parameters: CableSimParameters,
    *,
    sea_period: float,
    amplitude: float = 0.5,
    count: int = 4,
    longest: float | None = None,
    boom_tip: Sequence[float] = (0.0, 0.0, 0.0),
) -> ModesReport:
    """Return natural periods, mode shapes and the resonance map of a plant's cable and unit.

    Parameters
    ----------
    parameters : of the plant, whose seabed must be below the unit; the report names what of it has no part in the modes
    sea_period : whose resonant length is sought [s]
    amplitude : of the boom tip, for which drag is made linear [m]
    count : modes of heave
    longest : greatest length of the map [m]; the parameters' length if None
    boom_tip : position [m], which matters in a current that changes with depth

    Raises
    ------
    LinearisationError
        for a count, amplitude or length that is not positive.
    StaticsError, NoEquilibriumError, PlantError
        where the line does not hang free of the seabed, or would part.
    """
    longest = parameters.length if longest is None else longest
    if not (sea_period > 0.0 and amplitude > 0.0 and longest > 0.0 and count >= 1):
        raise LinearisationError("period, amplitude, longest length and number of modes must be positive")
    calm = _at_small_motion(parameters)
    _refuse_no_rest(calm, boom_tip)

    def axial_at(length: float) -> AxialLine:
        return axial_line(replace(calm, length=length), float(boom_tip[2]))

    lengths = np.linspace(SHORTEST_SHARE * longest, longest, MAP_LENGTHS, dtype=np.float64)
    omegas = 2.0 * math.pi / np.linspace(SHORTEST_PERIOD, LONGEST_PERIOD, MAP_PERIODS, dtype=np.float64)
    return ModesReport(
        length=parameters.length,
        amplitude=amplitude,
        sea_period=sea_period,
        heave=_heave_modes(axial_at(parameters.length), parameters.length, count),
        resonances=resonance_map(axial_at, lengths, omegas, amplitude=amplitude),
        natural_periods=np.array([_natural_period(axial_at, float(length)) for length in lengths]),
        critical_length=_critical_length(axial_at, sea_period, float(lengths[0]), longest),
        critical_estimate=resonant_length(axial_at(parameters.length), 2.0 * math.pi / sea_period),
        left_out=_left_out(parameters),
    )


def _refuse_no_rest(parameters: CableSimParameters, boom_tip: Sequence[float]) -> None:
    """Raise StaticsError or NoEquilibriumError for a line that does not hang under a `boom_tip`."""
    free = CableDynamics(replace(parameters, seabed=SeabedParameters()))
    free.start_at_equilibrium(boom_tip, 0.0)
    clearance_of(parameters, free.unit_position)
    strain = axial_line(parameters, float(np.asarray(boom_tip)[2])).static_strain(parameters.length)
    words = overstrained_words(strain, parameters.cable.axial_stiffness)
    if words:
        raise StaticsError(words)


def _at_small_motion(parameters: CableSimParameters) -> CableSimParameters:
    """Return the `parameters` with the added mass that the unit's table over KC has at KC = 0."""
    unit = parameters.unit
    if not unit.oscillation.kc:
        return parameters
    added = (*unit.added_mass[:2], unit.oscillation.added_mass[0])
    return replace(parameters, unit=replace(unit, added_mass=added, vertical_added_mass="given"))


def _left_out(parameters: CableSimParameters) -> tuple[str, ...]:
    """Return what of the `parameters` is set and has no part in the modes."""
    cable, unit = parameters.cable, parameters.unit
    given = {
        "cable.bending_stiffness": cable.bending_stiffness,
        "cable.loss_factor": cable.loss_factor,
        "compensator": parameters.compensator.stiffness,
        "rope_path.friction": parameters.rope_path.friction,
        "unit.oscillation (its added mass at KC = 0 is, its drag is not)": unit.oscillation.kc,
    }
    return tuple(name for name, value in given.items() if value)


def _heave_modes(line: AxialLine, length: float, count: int) -> tuple[HeaveMode, ...]:
    modes = []
    for omega in natural_frequencies(line, length, count):
        labels, shape = mode_shape(line, length, float(omega))
        modes.append(HeaveMode(2.0 * math.pi / float(omega), labels, shape))
    return tuple(modes)


def _natural_period(line_at: Callable[[float], AxialLine], length: float) -> float:
    return 2.0 * math.pi / float(natural_frequencies(line_at(length), length, 1)[0])


def _critical_length(
    line_at: Callable[[float], AxialLine], period: float, shortest: float, longest: float
) -> float | None:
    """Return the length at which the first heave mode has `period`; the period grows with the length."""
    if not _natural_period(line_at, shortest) <= period <= _natural_period(line_at, longest):
        return None
    return float(brentq(lambda length: _natural_period(line_at, length) - period, shortest, longest, xtol=1e-3))
