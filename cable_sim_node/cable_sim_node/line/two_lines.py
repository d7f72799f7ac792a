"""A second line to the same unit, as an umbilical beside the lift line (thesis 2.7).

The lift line is `CableDynamics` itself, the second line another one whose lower end is carried along the unit's path.
In an interval the unit feels the mean of the second line's pull at both ends, and the second line the unit's mean
acceleration; the interval is done twice, first with the pull as it went on. That is of second order, and leaves the
kernels of a single line as they are.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from heave_node.interface.waves import Waves
from heave_node.numerics.arrays import Array
from heave_node.numerics.kinematics import PointMotion
from numpy.typing import ArrayLike

from cable_sim_node.errors import NoEquilibriumError
from cable_sim_node.line import layout as at
from cable_sim_node.line.arrays import LineArrays
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.parameters import (
    CableSimParameters,
    ClumpsParameters,
    CompensatorParameters,
    RopePathParameters,
    SectionsParameters,
)
from cable_sim_node.physics.properties import cable_sections
from cable_sim_node.unit_parameters import UnitParameters

CARRIED = 1e9
"""Mass of the second line's lower end [kg]: no cable moves it by more than 1e-7 m in a tick."""
PASSES = 2
"""Times that an interval is done: first with the pull as it went on, then with the one found."""
CLOSED = 1e-6
"""Distance of both lower ends at the start [m]."""
ITERATIONS, HALVINGS = 60, 12
"""Of the search for the start."""


def second_line(parameters: CableSimParameters) -> CableSimParameters:
    """Return the second line of the `parameters` as a plant of its own, its lower end weightless and heavy to move."""
    given, density = parameters.second_line, max(parameters.water_density, 1.0)
    own = {"diameter": given.diameter, "displaced_diameter": 0.0, "mass_per_length": given.mass_per_length}
    none = (0.0, 0.0, 0.0)
    return replace(
        parameters,
        length=given.length,
        segments=given.segments,
        cable=replace(parameters.cable, axial_stiffness=given.axial_stiffness, **own),
        unit=UnitParameters(mass=CARRIED, volume=CARRIED / density, added_mass=none, drag_coefficient=none),
        sections=SectionsParameters(),
        clumps=ClumpsParameters(),
        compensator=CompensatorParameters(),
        rope_path=RopePathParameters(),
        second_line=replace(given, length=0.0),
    )


class TwoLines(CableDynamics):
    """The lift line with its unit, and the second line that pulls at it, as the `parameters` state them.

    All properties are the lift line's. The second line's length stays; its top moves as the boom tip does,
    `second_line.at` beside it. The second line is `second`, its own pull on the unit `second_pull` [N], shape (3,).
    """

    def __init__(self, parameters: CableSimParameters) -> None:
        self.second = CableDynamics(second_line(parameters))
        super().__init__(parameters)
        self._beside = np.array(parameters.second_line.at)
        section = cable_sections(self.second.parameters)[0].cable
        half = 0.5 * self.second.parameters.length / self.second.parameters.segments
        self._half_mass, self._half_weight = half * (section.mass + section.added_mass), half * section.weight
        self.second_pull = self._before = self._rest_drag = np.zeros(3)

    def start_at_equilibrium(self, boom_tip_position: ArrayLike, payout: float = 0.0, *, time: float = 0.0) -> None:
        """See CableDynamics: with both lines at rest, which the pull of the second one is searched for."""
        tip = np.array(boom_tip_position, dtype=float)

        def gap(pull: Array) -> Array:
            self._pull_at_unit(pull)
            self.second.set_thrust(-pull)
            try:
                super(TwoLines, self).start_at_equilibrium(tip, payout, time=time)
                self.second.start_at_equilibrium(tip + self._beside, time=time)
            except NoEquilibriumError:  # this pull lifts a lower end above its top
                return np.full(3, np.inf)
            return self.unit_position - self.second.unit_position

        super().start_at_equilibrium(tip, payout, time=time)
        pull = _closed(gap, self._first_pull(tip + self._beside - self.unit_position))
        self.second_pull = self._before = pull
        self._rest_drag = pull - self._pull(np.zeros(3))

    def advance(
        self,
        duration: float,
        tip_start: PointMotion,
        tip_end: PointMotion,
        payout_start: float,
        payout_rate_start: float,
        payout_end: float,
        payout_rate_end: float,
    ) -> None:
        """See CableDynamics."""
        begun = self._line, self.second.arrays
        start, pull = self.second_pull, 2.0 * self.second_pull - self._before
        place, velocity = self.unit_position, self.unit_velocity
        begin, end = (replace(tip, position=tip.position + self._beside) for tip in (tip_start, tip_end))
        for _ in range(PASSES):
            self._line, self.second._line = (LineArrays(*(part.copy() for part in line)) for line in begun)
            self._pull_at_unit(0.5 * (start + pull))
            super().advance(duration, tip_start, tip_end, payout_start, payout_rate_start, payout_end, payout_rate_end)
            acceleration = (self.unit_velocity - velocity) / duration
            self._carry(place, velocity, acceleration)
            self.second.advance(duration, begin, end, 0.0, 0.0, 0.0, 0.0)
            self._carry(self.unit_position, self.unit_velocity, acceleration)
            pull = self._pull(acceleration)
        self._before, self.second_pull = start, pull

    def set_waves(self, waves: Waves) -> None:
        """See CableDynamics."""
        super().set_waves(waves)
        self.second.set_waves(waves)

    def _pull_at_unit(self, pull: Array) -> None:
        self.set_thrust(np.array(self.parameters.unit.thrust) + pull)

    def _carry(self, place: Array, velocity: Array, acceleration: Array) -> None:
        """Put the second line's lower end at a `place` with a `velocity`, driven by an `acceleration`."""
        end = self.second.arrays.tiles[0]
        end[at.X : at.VX : at.STRIDE], end[at.VX : at.AX : at.STRIDE] = place, velocity
        end[at.AX : at.AX + 3 * at.STRIDE : at.STRIDE] = acceleration
        self.second.set_thrust(CARRIED * acceleration)

    def _pull(self, acceleration: Array) -> Array:
        """Return the second line's pull: its lowest segment's tension, half its weight, inertia and drag at rest."""
        nodes, tensions = self.second.nodes_and_tensions()
        along = nodes[1] - nodes[0]
        pull = tensions[0] * along / np.linalg.norm(along) - self._half_mass * acceleration + self._rest_drag
        pull[2] -= self._half_weight
        return np.asarray(pull)

    def _first_pull(self, span: Array) -> Array:
        """Return the pull of a shallow parabola over the `span` from the unit to its top [m], and half its weight."""
        given = self.parameters.second_line
        weight, distance = 2.0 * given.segments * self._half_weight, float(np.linalg.norm(span))
        slack = given.length / distance - 1.0
        across = weight * float(np.hypot(span[0], span[1])) / distance
        pull = across / np.sqrt(24.0 * max(slack, 1e-6)) + given.axial_stiffness * max(-slack, 0.0)
        pull = min(max(pull, 0.05 * weight), 0.3 * float(self.segment_tensions[0]))
        return np.asarray(pull * span / distance - np.array([0.0, 0.0, 0.5 * weight]))


def _closed(gap: Callable[[Array], Array], pull: Array) -> Array:
    """Return the pull at which a gap closes, by Newton from a first `pull`: both are monotone, and steps are halved.

    Raises NoEquilibriumError where it does not close.
    """
    here = gap(pull)
    for _ in range(ITERATIONS):
        if np.abs(here).max() < CLOSED:
            gap(pull)
            return pull
        h = 1e-5 * float(np.linalg.norm(pull))
        slopes = np.column_stack([(gap(pull + one) - here) / h for one in h * np.eye(3)])
        step = np.linalg.lstsq(np.nan_to_num(slopes), -here)[0]
        for halving in range(HALVINGS):
            share = 0.5**halving
            there = gap(pull + share * step)
            if np.linalg.norm(there) < (1.0 - 0.1 * share) * np.linalg.norm(here):
                break
        pull, here = pull + share * step, there
    raise NoEquilibriumError("the second line does not come to rest at the unit: check second_line.length and .at")
