"""Cable, unit and bodies as every model needs them: mass, weight in the fluid, drag per speed squared."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.hydrostatics import weight_in_fluid

from cable_sim_node.parameters import CableParameters, CableSimParameters
from cable_sim_node.physics.hydrodynamics import box_added_mass, wet_part


@dataclass(frozen=True)
class CableProperties:
    """A uniform cable, per unstretched metre."""

    axial_stiffness: float  # EA [N]
    quadratic: float  # coefficient of strain squared in the tension law [-], see `tension_law`
    cubic: float  # coefficient of strain cubed in the tension law [-], see `tension_law`
    internal_damping: float  # tension per strain rate [N s]
    mass: float  # of the cable [kg/m]
    added_mass: float  # added normal to the cable [kg/m]
    displaced_mass: float  # of the displaced fluid [kg/m]
    weight: float  # in the fluid, positive down [N/m]
    weight_in_air: float  # out of the fluid, positive down [N/m]
    normal_drag: float  # N of `drag` [N s2/m3]
    tangential_drag: float  # T of `drag` [N s2/m3]
    bending_stiffness: float  # EI [N m2]


@dataclass(frozen=True)
class CableSection:
    """A piece of uniform cable."""

    start: float  # unstretched length from the unit to its lower end [m]
    length: float  # unstretched [m]; infinite for the main cable, which the winch feeds
    cable: CableProperties  # what it is made of


@dataclass(frozen=True)
class UnitProperties:
    """The unit along x, y, z; each of shape (3,)."""

    inertia: Array  # mass and added mass [kg]
    drag: Array  # (1/2) rho C_D S [kg/m], each with its own component of the flow
    body_drag: float  # the same of an isotropic unit, along the flow [kg/m]; one of both is zero
    force: Array  # thrust, and weight less buoyancy [N]
    fluid: Array  # displaced and added mass, which moving water accelerates [kg]
    mass: float  # in air [kg]
    buoyancy: float  # [N]
    wet: float  # share of the unit that is under water [-]

    @property
    def vertical_drag(self) -> float:
        """(1/2) rho C_D S of vertical motion in still water [kg/m]."""
        return float(self.drag[2]) + self.body_drag


@dataclass(frozen=True)
class BodyProperties:
    """A body clamped on the cable."""

    label: float  # unstretched length from the unit [m]
    mass: float  # [kg]
    added_mass: float  # [kg]
    displaced_mass: float  # [kg]
    weight: float  # in the fluid, positive down [N]
    drag: float  # (1/2) rho C_D A, isotropic [kg/m]


def cable_sections(parameters: CableSimParameters) -> list[CableSection]:
    """Return the sections of the parameters' cable from the unit upwards; the last one is the main cable."""
    main, given = parameters.cable, parameters.sections
    sections = []
    start = 0.0
    for i, length in enumerate(given.length):
        cable = replace(
            main,
            diameter=given.diameter[i],
            displaced_diameter=given.displaced_diameter[i] if given.displaced_diameter else 0.0,
            mass_per_length=given.mass_per_length[i],
            axial_stiffness=given.axial_stiffness[i],
        )
        sections.append(CableSection(start, length, _cable_properties(parameters, cable)))
        start += length
    return [*sections, CableSection(start, math.inf, _cable_properties(parameters, main))]


def unit_properties(parameters: CableSimParameters, depth: float = math.inf) -> UnitProperties:
    """Return the unit of the `parameters`, far from the bottom; one with a box is as wet as it is at `depth` [m]."""
    unit, density = parameters.unit, parameters.water_density
    added = np.array(unit.added_mass) if density > 0.0 else np.zeros(3)
    if unit.vertical_added_mass == "box":
        box = unit.box
        added[2] = box_added_mass(box.length, box.breadth, box.height, density, box.perforation)
    slamming = 0.5 * density * unit.box.slamming * unit.box.area
    wet, vertical = wet_part.py_func(depth, box_height(parameters), slamming, float(added[2]))
    added = np.array([wet * added[0], wet * added[1], vertical])
    displaced = wet * density * unit.volume
    weight = unit.weight_in_fluid(wet * density, parameters.gravity)
    drag = 0.5 * wet * density * np.array(unit.drag_coefficient) * np.array(unit.drag_area)
    is_isotropic = unit.drag_law == "isotropic"
    return UnitProperties(
        inertia=unit.mass + added,
        drag=np.zeros(3) if is_isotropic else drag,
        body_drag=float(drag[0]) if is_isotropic else 0.0,
        force=np.array(unit.thrust) - np.array([0.0, 0.0, weight]),
        fluid=displaced + added,
        mass=unit.mass,
        buoyancy=displaced * parameters.gravity,
        wet=wet,
    )


def box_height(parameters: CableSimParameters) -> float:
    """Return the height over which the unit of the `parameters` gets wet [m]; 0 where water surrounds it always."""
    return parameters.unit.box.height if parameters.surface else 0.0


def depth_at_rest(parameters: CableSimParameters, depth_under: Callable[[float], float]) -> float:
    """Return a depth of the unit at which it is as wet as at rest [m]: infinite where it is all under water.

    Parameters
    ----------
    parameters : of the plant
    depth_under : depth [m] at which the cable holds a unit that is as wet as it is at the depth given [m]: the wetter
        the unit, the less it pulls, and the higher it hangs
    """
    height = box_height(parameters)
    if height == 0.0:
        return math.inf
    if depth_under(0.0) <= 0.0:
        return 0.0
    if depth_under(height) >= height:
        return math.inf
    from scipy.optimize import brentq  # noqa: PLC0415 (0.1 s, and every command comes here)

    return float(brentq(lambda depth: depth - depth_under(depth), 0.0, height, xtol=1e-9))


def body_properties(parameters: CableSimParameters) -> list[BodyProperties]:
    """Return the bodies on the parameters' cable, in the order in which they were given."""
    clumps, density = parameters.clumps, parameters.water_density
    return [
        BodyProperties(
            label=label,
            mass=mass,
            added_mass=added_mass if density > 0.0 else 0.0,
            displaced_mass=density * volume,
            weight=weight_in_fluid(mass, volume, density, parameters.gravity),
            drag=0.5 * density * drag_area,
        )
        for label, mass, volume, added_mass, drag_area in zip(
            clumps.position, clumps.mass, clumps.volume, clumps.added_mass, clumps.drag_area, strict=True
        )
    ]


def _cable_properties(parameters: CableSimParameters, cable: CableParameters) -> CableProperties:
    density = parameters.water_density
    return CableProperties(
        axial_stiffness=cable.axial_stiffness,
        quadratic=cable.stiffness_quadratic,
        cubic=cable.stiffness_cubic,
        internal_damping=cable.internal_damping,
        mass=cable.mass_per_length,
        added_mass=density * cable.added_mass * cable.displaced_area,
        displaced_mass=density * cable.displaced_area,
        weight=cable.weight_in_fluid(density, parameters.gravity),
        weight_in_air=cable.weight_in_fluid(0.0, parameters.gravity),
        normal_drag=0.5 * density * cable.normal_drag * cable.diameter,
        tangential_drag=0.5 * math.pi * density * cable.tangential_drag * cable.diameter,
        bending_stiffness=cable.bending_stiffness,
    )
