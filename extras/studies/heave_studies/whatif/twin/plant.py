"""The plant of a record: cable and unit as identified, driven by the boom tip of the record and any payout."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from cable_sim_node.vertical.axial_line import AxialLine
from cable_sim_node.vertical.axial_stepper import AxialInput, AxialStepper
from heave_node.numerics.arrays import Array
from winch_controller_node.design.design import assumed_cable, assumed_plant
from winch_controller_node.node_parameters import WinchControllerParameters

from heave_studies.whatif.signals.tip import Tip

SEGMENTS, SUBSTEPS = 12, 4
"""Elements along the cable, and steps in a tick: 0.4 mm of a motion of 0.6 m (sigma) from a mesh refined threefold."""


@dataclass(frozen=True)
class PlantFactors:
    """What cable and unit are, over what the parameters say."""

    inertia: float = 1.0  # on a, the unit's inertia over the cable's stiffness [-]
    damping: float = 1.0  # on the drag of the unit [-]
    cable_drag: float = 1.0  # on the drag of the cable [-]
    stiffness: float = 1.0  # on EA [-]; masses and drag go with it, so that the motion stays and the tension grows


def nominal_line(parameters: WinchControllerParameters) -> AxialLine:
    """Return cable and unit as the `parameters` of a controller state them, its own a and factors with them."""
    assumed = parameters.cable_model
    derived = replace(parameters, cable_model=replace(assumed, inertia=0.0, inertia_factor=1.0))
    a, length = assumed_cable(parameters, parameters.length).a, parameters.length
    drag = assumed.damping_factor
    factors = PlantFactors(a / assumed_cable(derived, length).a, drag, drag)
    return scaled_line(assumed_plant(parameters).line(length), factors)


def scaled_line(line: AxialLine, factors: PlantFactors) -> AxialLine:
    """Return a `line` with `factors` on it."""
    # all forces grow with the stiffness, so that the motion stays
    mass, unit_drag, cable_drag = (
        one * factors.stiffness for one in (factors.inertia, factors.damping, factors.cable_drag)
    )
    sections = tuple(
        replace(
            one,
            axial_stiffness=one.axial_stiffness * factors.stiffness,
            mass=one.mass * mass,
            drag=one.drag * cable_drag,
        )
        for one in line.sections
    )
    unit = replace(line.unit, inertia=line.unit.inertia * mass, drag=line.unit.drag * unit_drag)
    return replace(line, sections=sections, unit=unit)


def twin_stepper(line: AxialLine, length: float, start: Iterable[float], tick_period: float) -> AxialStepper:
    """Return the twin of cable and unit.

    Parameters
    ----------
    line : cable and unit
    length : unstretched cable at payout 0 [m]
    start : heave and its rate of the boom tip, payout and its rate at the first tick [m], [m/s]
    tick_period : [s]
    """
    return AxialStepper(line, length, AxialInput(*start), segments=SEGMENTS, duration=tick_period, substeps=SUBSTEPS)


@dataclass(frozen=True)
class PlantMotion:
    """Motion of the plant at each tick."""

    unit: Array  # heave of the unit about its rest at payout 0, positive up (n,) [m]
    velocity: Array  # its rate (n,) [m/s]
    tension: Array  # at the top (n,) [N]
    least_tension: Array  # the smallest along the cable (n,) [N]


class Drive(NamedTuple):
    """What moves a plant."""

    line: AxialLine  # cable and unit
    length: float  # unstretched, of the cable at payout 0 [m]
    tip: Tip  # of the record
    payout: Array  # of the cable at each tick (n,) [m]
    rate: Array  # of the cable at each tick (n,) [m/s]
    tick_period: float  # [s]


def driven(line: AxialLine, length: float, tip: Tip, payout: Array, rate: Array, tick_period: float) -> PlantMotion:
    """Return the motion of the plant under a given payout.

    Parameters
    ----------
    line, length, tip, payout, rate, tick_period : as for Drive
    """
    rows = np.column_stack((tip.heave, tip.rate, payout, rate))
    stepper = twin_stepper(line, length, rows[0], tick_period)
    table = np.vstack((stepper.state, stepper.follow(rows[1:])))
    return PlantMotion(*table.T.copy())


Follow = Callable[[Sequence[Drive]], list[PlantMotion]]
"""What returns the motions of plants, each under its drive."""


def followed(drives: Sequence[Drive]) -> list[PlantMotion]:
    """Return the motion of a plant under each of some `drives`, one after the other."""
    return [driven(*one) for one in drives]
