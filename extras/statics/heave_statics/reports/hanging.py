"""Unit and cable at rest below the boom tip: forces, positions, top tension and angle."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from cable_sim_node.line.rest.hanging import refuse_floating
from cable_sim_node.parameters import CableSimParameters
from cable_sim_node.physics.current import current_of
from cable_sim_node.physics.properties import cable_sections, unit_properties
from cable_sim_node.physics.seabed import clearance_of
from cable_sim_node.reports.report import labelled_rows
from heave_node.numerics.arrays import Array
from heave_node.sheet import Column, Sheet
from numpy.typing import ArrayLike

from heave_statics.problems import towing_cable
from heave_statics.shape import StaticShape
from heave_statics.suspended import shape_at_rest
from heave_statics.tables import LENGTH

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class HangingReport:
    """Static equilibrium of unit and cable under the boom tip, winch locked."""

    shape: StaticShape  # the whole shape, s = 0 at the unit
    boom_tip: Array  # position, z up [m]
    unit: Array  # position, z up [m]
    boom_tip_force: Array  # force by which the ship holds the cable [N]
    unit_weight: float  # weight of the unit less its buoyancy [N]
    unit_wet: float  # share of the unit that is under water [-]
    unit_pull: Array  # force of the cable on the unit [N]
    seabed_depth: float | None  # [m] below the origin, None without a seabed
    clearance: float | None  # height of the unit above the seabed below it [m], None without a seabed
    # by how much the water's pressure shortens the cable [m], see `pressure_shortening`; the shape is without it
    pressure_shortening: float

    @property
    def largest_tension(self) -> float:
        """Tension at the boom tip [N]."""
        return self.shape.top_tension

    @property
    def unit_load(self) -> float:
        """Size of the force of the cable on the unit [N]."""
        return float(np.linalg.norm(self.unit_pull))

    @property
    def top_azimuth(self) -> float:
        """Direction in which the cable leaves the boom tip, from x towards y [rad]."""
        return math.atan2(-self.boom_tip_force[1], -self.boom_tip_force[0])

    @property
    def horizontal_offset(self) -> float:
        """Distance of the unit from below the boom tip [m]."""
        return float(np.hypot(*(self.unit - self.boom_tip)[:2]))

    def values(self) -> dict[str, object]:
        """Return the numbers with units in their names, for a machine."""
        return REPORT.record(self)

    def table(self) -> str:
        """Return the report as text for a person."""
        rows = [("", "           x             y             z"), *REPORT.lines(self)]
        if self.clearance is not None:
            rows.append(("unit above the seabed [m]", f"{self.clearance:12.3f}"))
        return labelled_rows([(name.format(where=self._where), cell) for name, cell in rows])

    @property
    def _where(self) -> str:
        if 0.0 < self.unit_wet < 1.0:
            return f"{100.0 * self.unit_wet:.1f} % under water"
        return "in water" if self.unit_wet else "in air"

    def draw(self, figure: Figure) -> None:
        """Draw x-z, y-z and x-y views into `figure`, coloured by tension."""
        from matplotlib.cm import ScalarMappable  # noqa: PLC0415 (slow to import, rarely needed)
        from matplotlib.colors import Normalize  # noqa: PLC0415 (slow to import, rarely needed)

        curve = self.shape.curve()
        labels = np.interp(
            np.linspace(0.0, len(self.shape.positions) - 1, len(curve)),
            np.arange(len(self.shape.positions)),
            self.shape.cable.labels,
        )
        tension = np.interp(labels, self.shape.cable.labels, self.shape.tension)
        span = max(float(np.ptp(curve, axis=0).max()), self.shape.cable.segments[0, LENGTH])
        axes = figure.subplots(1, 3)
        colours = Normalize(float(tension.min()) / 1e3, float(tension.max()) / 1e3)
        for axis, (across, up) in zip(axes, ((0, 2), (1, 2), (0, 1)), strict=True):
            axis.plot(curve[:, across], curve[:, up], color="0.7", linewidth=1.0)
            axis.scatter(
                curve[:, across], curve[:, up], c=tension / 1e3, s=6.0, cmap="viridis", norm=colours, rasterized=True
            )
            axis.plot(self.unit[across], self.unit[up], "ks", markersize=7.0, label="unit")
            axis.plot(self.boom_tip[across], self.boom_tip[up], "r^", markersize=7.0, label="boom tip")
            axis.set_xlabel(f"{'xyz'[across]} [m]")
            axis.set_ylabel(f"{'xyz'[up]} [m]")
            if float(np.ptp(curve[:, across])) < 0.02 * span:
                middle = float(curve[:, across].mean())
                axis.set_xlim(middle - 0.1 * span, middle + 0.1 * span)
            if self.seabed_depth is not None and up == 2:
                axis.axhline(-self.seabed_depth, color="saddlebrown", linewidth=2.0)
            axis.grid(alpha=0.3)
        axes[0].legend(loc="best", fontsize="small")
        figure.colorbar(ScalarMappable(colours, "viridis"), ax=axes, label="tension [kN]")
        figure.suptitle(
            f"{self.shape.cable.length:g} m out: top tension {self.largest_tension / 1e3:.2f} kN,"
            f" top angle {math.degrees(self.shape.top_angle):.2f} deg"
        )


def _vector(values: Sequence[float]) -> str:
    return "  ".join(f"{value:12.3f}" for value in values)


def _kilo(values: Sequence[float]) -> str:
    return _vector([value / 1e3 for value in values])


def _listed(name: str) -> Callable[[HangingReport], list[float]]:
    """Return the function that lists a vector of a report, without -0."""
    return lambda report: (getattr(report, name) + 0.0).tolist()


REPORT = Sheet(
    Column("boom tip [m]", _listed("boom_tip"), "boom_tip_m", _vector),
    Column("unit [m]", _listed("unit"), "unit_m", _vector),
    Column("force on the cable at the boom tip [kN]", _listed("boom_tip_force"), "boom_tip_force_n", _kilo),
    Column("force of the cable on the unit [kN]", _listed("unit_pull"), "unit_pull_n", _kilo),
    Column("unstretched length [m]", "shape.cable.length", "length_m", "12.3f"),
    Column("", "shape.stretched_length", "stretched_length_m"),
    Column("stretch [m]", lambda one: one.shape.stretched_length - one.shape.cable.length, form="12.4f"),
    Column("shortening by water pressure, at most [m]", "pressure_shortening", "pressure_shortening_m", "12.4f"),
    Column("horizontal offset of the unit [m]", "horizontal_offset", "horizontal_offset_m", "12.3f"),
    Column("weight of the unit {where} [kN]", "unit_weight", "unit_weight_n", "12.3f", 1e-3),
    Column("", lambda one: 100.0 * one.unit_wet, "unit_wet_percent"),
    Column("top tension [kN]", "largest_tension", "top_tension_n", "12.3f", 1e-3),
    Column(
        "top angle from the vertical [deg]", lambda one: math.degrees(one.shape.top_angle), "top_angle_deg", "12.3f"
    ),
    Column("", lambda one: math.degrees(one.top_azimuth), "top_azimuth_deg"),
    Column("smallest tension [kN]", lambda one: float(one.shape.tension.min()), "least_tension_n", "12.3f", 1e-3),
    Column("", "clearance", "clearance_m"),
)
"""Lines of the report; `where` is the water or the air."""


def pressure_shortening(parameters: CableSimParameters, shape: StaticShape) -> float:
    """Return by how much the water's pressure shortens a cable [m]: the integral of p A/EA, p = rho g y.

    With the effective tension T, of which the weight in water is the slope, the strain is (T - p A)/EA (Pinto, Eq. 16,
    which prints rho for rho g). This is the second part of it. It takes the cable as closed, and as not thicker for
    being shorter: water that gets between the wires leaves a part of it only.

    Parameters
    ----------
    parameters : of the plant
    shape : of its cable at rest
    """
    labels, heights = shape.cable.labels, shape.positions[:, 2]
    middles, sections = 0.5 * (labels[1:] + labels[:-1]), cable_sections(parameters)
    owners = np.searchsorted([section.start for section in sections], middles, side="right") - 1
    squeeze = np.array([section.cable.displaced_mass / section.cable.axial_stiffness for section in sections])
    depths = np.maximum(-0.5 * (heights[1:] + heights[:-1]), 0.0)
    return float(parameters.gravity * np.sum(squeeze[owners] * depths * np.diff(labels)))


def hanging_report(parameters: CableSimParameters, boom_tip: ArrayLike = (0.0, 0.0, 0.0)) -> HangingReport:
    """Return the static equilibrium of a plant's cable and unit at payout 0.

    Bending stiffness, waves, passive compensator and rope path have no part in it.

    Parameters
    ----------
    parameters : of the plant
    boom_tip : position [m], z up

    Raises
    ------
    StaticsError
        if sections or bodies do not fit on the cable, the unit would lie below the seabed, or the cable would be
        strained too much.
    NoEquilibriumError
        if the current's equilibrium cannot be reached, or the unit would float above the boom tip.
    """
    tip = np.asarray(boom_tip, dtype=np.float64)
    current = current_of(parameters)
    shape = shape_at_rest(parameters, lambda cable: towing_cable(cable, tip, current))
    unit = shape.positions[0]
    wet = unit_properties(parameters, -float(unit[2])).wet
    refuse_floating(float(unit[2]), float(tip[2]))
    seabed = parameters.seabed
    clearance = clearance_of(parameters, unit)
    return HangingReport(
        shape=shape,
        boom_tip=tip,
        unit=unit,
        boom_tip_force=shape.end_force,
        unit_weight=parameters.unit.weight_in_fluid(wet * parameters.water_density, parameters.gravity),
        unit_wet=wet,
        unit_pull=shape.lower[0],
        seabed_depth=seabed.depth if seabed.depth > 0.0 else None,
        clearance=clearance,
        pressure_shortening=pressure_shortening(parameters, shape),
    )
