"""What the axial models know of cable and unit: the few numbers that vertical motion depends on."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, fields, replace

import numpy as np
from heave_node.numerics.arrays import Array

from cable_sim_node.errors import NoEquilibriumError
from cable_sim_node.parameters import CableSimParameters
from cable_sim_node.physics.properties import body_properties, cable_sections, depth_at_rest, unit_properties
from cable_sim_node.physics.tension_law import strain_at, tangent_stiffness, yielding_words
from cable_sim_node.vertical import axial_layout as at


@dataclass(frozen=True)
class AxialSection:
    """One uniform piece of cable, per unstretched metre."""

    length: float  # [m]; the uppermost section continues indefinitely, whatever its length, because the winch feeds it
    axial_stiffness: float  # EA [N]
    mass: float  # [kg/m], with the tangential added mass if there is any
    weight: float  # in water, positive down [N/m]
    drag: float = 0.0  # tangential drag over speed squared, (pi/2) rho C_tau d (thesis Eq. 3.1) [N s2/m3]
    damping_time: float = 0.0  # of the internal damping, T = EA (strain + damping_time * strain rate) [s]


@dataclass(frozen=True)
class AxialUnit:
    """The subsea unit in vertical motion."""

    inertia: float  # mass and vertical added mass [kg]
    weight: float  # in water, positive down [N]
    drag: float = 0.0  # over speed squared, rho C_D S / 2 (thesis Eq. 3.3) [N s2/m2]


@dataclass(frozen=True)
class AxialClump:
    """A body clamped on the cable."""

    label: float  # unstretched length from the unit [m]
    inertia: float  # mass and added mass [kg]
    weight: float  # in water, positive down [N]
    drag: float = 0.0  # over speed squared [N s2/m2]


@dataclass(frozen=True)
class AxialPiece(AxialSection):
    """A piece of the cable that is out, and the clumps at its lower end."""

    clumps: tuple[AxialClump, ...] = ()


@dataclass(frozen=True)
class AxialLine:
    """Cable and unit as the axial models know them."""

    sections: tuple[AxialSection, ...]  # of cable, from the unit upwards
    unit: AxialUnit  # the unit
    clumps: tuple[AxialClump, ...] = ()  # bodies on the cable, in the order of their labels
    # of what gives between drum and boom tip, above the cable [N/m]; the linear models alone have it
    top_stiffness: float = math.inf

    def starts(self) -> Array:
        """Labels at which the sections begin [m], counted from the unit."""
        lengths = [section.length for section in self.sections[:-1]]
        return np.concatenate(([0.0], np.cumsum(lengths)))

    def section_table(self) -> Array:
        """Return the rows of the sections as the axial kernel takes them; columns in `axial_layout`."""
        table = np.zeros((len(self.sections), at.SECTION_COLUMNS))
        table[:, at.START] = self.starts()
        density, total = (
            table[:, at.DENSITY : at.DENSITY + at.QUANTITIES],
            table[:, at.TOTAL : at.TOTAL + at.QUANTITIES],
        )
        for row, s in zip(density, self.sections, strict=True):
            row[[at.COMPLIANCE, at.MASS, at.WEIGHT, at.DRAG, at.DELAY]] = (
                1.0 / s.axial_stiffness,
                s.mass,
                s.weight,
                s.drag,
                s.damping_time,
            )
        lengths = np.array([section.length for section in self.sections[:-1]])
        total[1:] = np.cumsum(density[:-1] * lengths[:, np.newaxis], axis=0)
        return table

    def section_at(self, label: float) -> AxialSection:
        """Return the section to which the point at `label` [m] belongs."""
        return self.sections[int(np.searchsorted(self.starts(), label, side="right")) - 1]

    def pieces(self, length: float) -> list[AxialPiece]:
        """Return the `length` [m] of cable that is out, cut at joints and bodies, from the unit upwards."""
        marks = {0.0, length, *self.starts(), *(clump.label for clump in self.clumps)}
        cuts = sorted(float(mark) for mark in marks if mark <= length)
        pieces = []
        for low, high in itertools.pairwise(cuts):
            section = self.section_at(0.5 * (low + high))
            values = {field.name: getattr(section, field.name) for field in fields(AxialSection)}
            bodies = tuple(clump for clump in self.clumps if clump.label == low)
            pieces.append(AxialPiece(**{**values, "length": high - low}, clumps=bodies))
        return pieces

    def static_stretch(self, length: float) -> float:
        """Return the elongation of `length` [m] of cable under weight in still water [m]."""
        stretch, load = 0.0, self.unit.weight
        for piece in self.pieces(length):
            load += sum(clump.weight for clump in piece.clumps)
            stretch += piece.length * (load + 0.5 * piece.weight * piece.length) / piece.axial_stiffness
            load += piece.weight * piece.length
        return stretch

    def static_strain(self, length: float) -> float:
        """Return the largest strain of `length` [m] of cable under weight in still water [-]."""
        largest, load = 0.0, self.unit.weight
        for piece in self.pieces(length):
            load += sum(clump.weight for clump in piece.clumps)
            ends = load, load + piece.weight * piece.length
            largest, load = max(largest, *(end / piece.axial_stiffness for end in ends)), ends[1]
        return largest

    def static_top_tension(self, length: float) -> float:
        """Return the tension at the top of `length` [m] of cable in still water [N]."""
        weight = self.unit.weight
        for piece in self.pieces(length):
            weight += piece.weight * piece.length + sum(clump.weight for clump in piece.clumps)
        return weight


def axial_line(parameters: CableSimParameters, boom_tip_height: float = -math.inf) -> AxialLine:
    """Return the axial model's view of a plant: vertical weight, stiffness, inertia and drag.

    Parameters
    ----------
    parameters : of the plant
    boom_tip_height : above still water [m]: a unit with a box is as wet as it is at rest on `parameters.length` below
        it; all of it is under water if not given

    The model is linear elastic. A tension law of the `parameters` that is not straight is taken by its slope at the
    static tension half-way along each section at payout 0, which is right for motion about rest. The vertical part of
    the unit's thrust counts as weight.

    Raises
    ------
    NoEquilibriumError
        if the tension law does not reach the static tension, or falls there.
    """
    sections = [
        AxialSection(
            length=section.length,
            axial_stiffness=section.cable.axial_stiffness,
            mass=section.cable.mass,
            weight=section.cable.weight,
            drag=section.cable.tangential_drag,
            damping_time=section.cable.internal_damping / section.cable.axial_stiffness,
        )
        for section in cable_sections(parameters)
    ]
    bodies = [
        AxialClump(body.label, body.mass + body.added_mass, body.weight, body.drag)
        for body in body_properties(parameters)
    ]
    clumps = tuple(sorted(bodies, key=lambda body: body.label))

    def line_at(depth: float) -> AxialLine:
        unit = unit_properties(parameters, depth)
        own = AxialUnit(float(unit.inertia[2]), -float(unit.force[2]), unit.vertical_drag)
        return AxialLine(tuple(sections), own, clumps, parameters.rope_path.stiffness or math.inf)

    def depth_under(depth: float) -> float:
        return parameters.length + line_at(depth).static_stretch(parameters.length) - boom_tip_height

    line = line_at(depth_at_rest(parameters, depth_under))
    cable = parameters.cable
    if cable.stiffness_quadratic == 0.0 and cable.stiffness_cubic == 0.0:
        return line
    return _at_static_tension(parameters, line)


def _at_static_tension(parameters: CableSimParameters, line: AxialLine) -> AxialLine:
    """Return `line` with each section's EA replaced by the slope of its tension law at rest."""
    sections = []
    for axial, section in zip(line.sections, cable_sections(parameters), strict=True):
        start, cable = section.start, section.cable
        end = max(min(start + section.length, parameters.length), start + 1e-6 * parameters.length)
        law = (cable.axial_stiffness, cable.quadratic, cable.cubic)
        strain = strain_at(*law, line.static_top_tension(0.5 * (start + end)))
        stiffness = tangent_stiffness(*law, strain)
        if not (math.isfinite(strain) and stiffness > 0.0):
            raise NoEquilibriumError(f"{yielding_words(cable.quadratic, cable.cubic)} ({start:g} m above the unit)")
        delay = axial.damping_time * axial.axial_stiffness / stiffness
        sections.append(replace(axial, axial_stiffness=stiffness, damping_time=delay))
    return replace(line, sections=tuple(sections))
