"""What the axial models know of cable and unit: the few numbers that vertical motion depends on."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cable_sim_node.parameters import CableParameters, CableSimParameters

Array = NDArray[np.float64]


@dataclass(frozen=True)
class AxialSection:
    """One uniform piece of cable, per unstretched metre.

    Attributes
    ----------
    length : [m]; the uppermost section goes on for ever, whatever its length, because the winch feeds it
    axial_stiffness : EA [N]
    mass : [kg/m], with the tangential added mass if there is any
    weight : in water, positive down [N/m]
    drag : tangential drag over speed squared, (pi/2) rho C_tau d (thesis Eq. 3.1) [N s2/m3]
    damping_time : of the internal damping, T = EA (strain + damping_time * strain rate) [s]
    """

    length: float
    axial_stiffness: float
    mass: float
    weight: float
    drag: float = 0.0
    damping_time: float = 0.0


@dataclass(frozen=True)
class AxialUnit:
    """The subsea unit in vertical motion.

    Attributes
    ----------
    inertia : mass and vertical added mass [kg]
    weight : in water, positive down [N]
    drag : over speed squared, rho C_D S / 2 (thesis Eq. 3.3) [N s2/m2]
    """

    inertia: float
    weight: float
    drag: float = 0.0


@dataclass(frozen=True)
class AxialLine:
    """Cable (sections counted from the unit upwards) and unit."""

    sections: tuple[AxialSection, ...]
    unit: AxialUnit

    def starts(self) -> Array:
        """Labels at which the sections begin [m], counted from the unit."""
        lengths = [section.length for section in self.sections[:-1]]
        return np.concatenate(([0.0], np.cumsum(lengths)))

    def densities(self) -> Array:
        """Return shape (5, sections): 1/EA, mass, weight, drag and damping time, per metre."""
        rows = [(1.0 / s.axial_stiffness, s.mass, s.weight, s.drag, s.damping_time) for s in self.sections]
        return np.ascontiguousarray(np.array(rows).T)

    def totals(self) -> Array:
        """Return shape (5, sections): the integrals of `densities` from the unit to each section's start."""
        lengths = np.array([section.length for section in self.sections[:-1]])
        sums = np.cumsum(self.densities()[:, :-1] * lengths, axis=1)
        return np.concatenate((np.zeros((5, 1)), sums), axis=1)

    def pieces(self, length: float) -> list[AxialSection]:
        """Return the sections of the cable that is out, from the unit upwards, cut at `length` [m]."""
        pieces = []
        left = length
        for section in self.sections[:-1]:
            if section.length >= left:
                break
            pieces.append(section)
            left -= section.length
        return [*pieces, replace(self.sections[len(pieces)], length=left)]

    def static_stretch(self, length: float) -> float:
        """Elongation under weight in still water [m]."""
        stretch, load = 0.0, self.unit.weight
        for piece in self.pieces(length):
            stretch += piece.length * (load + 0.5 * piece.weight * piece.length) / piece.axial_stiffness
            load += piece.weight * piece.length
        return stretch

    def static_top_tension(self, length: float) -> float:
        """Tension at the top in still water [N]."""
        return self.unit.weight + sum(piece.weight * piece.length for piece in self.pieces(length))


def axial_line(parameters: CableSimParameters) -> AxialLine:
    """Return the axial model's view of a cable system: vertical weight, stiffness, inertia and drag.

    Linear elastic (EA at small strain); the vertical part of the unit's thrust counts as weight; clumps are not part of
    it.
    """
    density, gravity = parameters.water_density, parameters.gravity
    cable, extra, unit = parameters.cable, parameters.sections, parameters.unit
    friction = 0.5 * math.pi * density * cable.tangential_drag
    sections = []
    for index, size in enumerate(extra.length):
        displaced = extra.displaced_diameter[index] if extra.displaced_diameter else 0.0
        piece = replace(
            cable,
            diameter=extra.diameter[index],
            displaced_diameter=displaced,
            mass_per_length=extra.mass_per_length[index],
            axial_stiffness=extra.axial_stiffness[index],
        )
        sections.append(_section(piece, size, friction, piece.weight_in_fluid(density, gravity)))
    sections.append(_section(cable, math.inf, friction, cable.weight_in_fluid(density, gravity)))
    return AxialLine(
        tuple(sections),
        AxialUnit(
            inertia=unit.mass + unit.added_mass[2],
            weight=unit.weight_in_fluid(density, gravity) - unit.thrust[2],
            drag=0.5 * density * unit.drag_coefficient[2] * unit.drag_area[2],
        ),
    )


def _section(cable: CableParameters, length: float, friction: float, weight: float) -> AxialSection:
    return AxialSection(
        length=length,
        axial_stiffness=cable.axial_stiffness,
        mass=cable.mass_per_length,
        weight=weight,
        drag=friction * cable.diameter,
        damping_time=cable.internal_damping / cable.axial_stiffness,
    )
