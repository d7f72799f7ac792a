"""Three-dimensional dynamics of a unit on a cable with a moving top end and a changing length: the plant's solver.

>>> cable = CableDynamics(CableSimParameters())
>>> cable.start_at_equilibrium(np.zeros(3), payout=0.0)
>>> tip = PointMotion()
>>> cable.advance(0.05, tip, tip, 0.0, 0.0, 0.0, 0.0)
"""

from __future__ import annotations

import math

import numpy as np
from heave_node.interface.waves import NO_WAVES, Waves
from heave_node.numerics.arrays import Array
from heave_node.numerics.kinematics import PointMotion
from heave_node.parameters import ParameterError
from numpy.typing import ArrayLike

from cable_sim_node.errors import (
    BadMotionError,
    CableTooShortError,
    NotConvergedError,
    PlantError,
    refuse_jump,
)
from cable_sim_node.line import layout as at
from cable_sim_node.line.arrays import LineArrays
from cable_sim_node.line.feed import set_top_segment
from cable_sim_node.line.grid import build_line, settings_of, with_waves
from cable_sim_node.line.observation import observe, snapshot
from cable_sim_node.line.rest.hanging import hang, refuse_floating
from cable_sim_node.line.rest.settling import hold_here, hold_strains, settle
from cable_sim_node.line.step import advance
from cable_sim_node.parameters import CableSimParameters, WaveKinematicsParameters
from cable_sim_node.physics.properties import unit_properties
from cable_sim_node.physics.seabed import Seabed


class CableDynamics:
    """A cable with a unit at its lower end, in frame `world` (z up, origin at still water), SI units.

    The lumped-mass model of thesis chapter 5 (Eq. 5.1-5.6, with the right projection I - e e'): node 0 is the unit,
    node N the top end, which is the boom tip (or the sheave that a passive compensator or a soft boom carries). Cable
    that is paid out or hauled in passes the top end; everything below is material that stays itself, so N changes with
    the length.
    Water ends at its surface, z = 0 and the wave on it, unless the parameters let it surround everything: cable above
    it is in air, and a unit with a box gets wet on its way through.

    Time: `advance` takes the motion at the start and at the end of an interval; all properties are those of the end of
    the last interval. Two objects share nothing; `copy.deepcopy` makes a second one in the same state.

    Raises ParameterError where the parameters contradict one another.
    """

    def __init__(self, parameters: CableSimParameters) -> None:
        self.parameters = parameters
        _check_seabed(parameters)
        self._seabed = Seabed(parameters.seabed)
        self._line = build_line(parameters, 2.0 * parameters.length)
        self._waves = _regular_waves(parameters.wave)
        self._fresh = False

    def start_at_equilibrium(self, boom_tip_position: ArrayLike, payout: float = 0.0, *, time: float = 0.0) -> None:
        """Put the line at rest, exactly in equilibrium: hanging, or on the seabed what reaches it.

        What is longer than the way down lies along the seabed, down the current, or along x where there is none.

        Parameters
        ----------
        boom_tip_position : [m], shape (3,)
        payout : cable let out beyond the parameters' length [m]
        time : simulated time, whose current flows [s]

        Raises
        ------
        NoEquilibriumError
            where the line does not hang, or does not come to rest on the seabed.
        CableTooShortError
            for less cable than a segment can shrink to.
        PlantError
            where a compensator's preload cannot be met.
        """
        boom_tip = np.array(boom_tip_position, dtype=float)
        total = self.parameters.length + payout
        if boom_tip.shape != (3,) or not np.all(np.isfinite(boom_tip)) or not math.isfinite(total):
            raise BadMotionError(
                f"boom tip must be three finite numbers and payout one; got {boom_tip.tolist()} and {payout}"
            )
        if total > self._line.numbers[at.GRID_END]:
            self._grow(total)
        line, numbers = self._line, self._line.numbers
        points = line.grid_points
        if total < at.MERGE_AT * points[1]:
            raise CableTooShortError(
                f"{total:g} m of cable is too short: a segment of {points[1]:g} m can shrink to "
                f"{at.MERGE_AT * points[1]:g} m at least; use more segments"
            )
        numbers[at.NOW : at.SETTINGS] = 0.0
        numbers[at.SETTINGS :] = settings_of(self.parameters)
        numbers[at.SPRING_ON] = 0.0
        line.write(at.PART, line.read(at.GRID + at.PART, at.PART_COLUMNS, len(points)))
        numbers[at.NOW : at.NOW + 3] = boom_tip
        numbers[at.NOW + at.TIME], numbers[at.NOW + at.TOTAL] = time, total
        n = max(int(np.searchsorted(points, total - 1e-9 * total)), 1)
        if n > 1 and total - points[n - 1] < at.MERGE_AT * (points[n] - points[n - 1]):
            n -= 1
        numbers[at.SEGMENTS] = n
        set_top_segment(n, total, line.tiles)
        self._line = with_waves(line, NO_WAVES)
        self._rest(boom_tip)
        self.set_waves(self._waves)
        self._start_compensator()

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
        """Integrate over an interval; boom tip and payout run as cubics through their values and rates at both ends.

        Parameters
        ----------
        duration : [s], above 0
        tip_start, tip_end : motion of the boom tip; only positions and velocities are used
        payout_start, payout_rate_start : at the start [m], [m/s]; the payout must be the present one
        payout_end, payout_rate_end : at the end [m], [m/s]

        Raises
        ------
        BadMotionError
            for numbers that are not finite, and for a payout that jumps; nothing is changed.
        CableTooShortError, NotConvergedError
            where the line cannot follow; the state is that of the last good step.
        """
        base = self.parameters.length
        ends = (base + payout_start, 0.0 + payout_rate_start, base + payout_end, 0.0 + payout_rate_end)
        motion = (tip_start.position, tip_start.velocity, tip_end.position, tip_end.velocity)
        outcome = advance(*self._line, *motion, (0.0 + duration, *ends))
        if outcome == at.GRID_TOO_SHORT:
            self._grow(max(ends[0], ends[2]) + duration * max(abs(ends[1]), abs(ends[3])))
            outcome = advance(*self._line, *motion, (0.0 + duration, *ends))
        self._fresh = outcome == at.DONE or (self._fresh and outcome == at.BAD_MOTION)
        if outcome == at.DONE:
            return
        if outcome == at.BAD_MOTION:
            if duration > 0.0 and math.isfinite(sum(ends) + sum(float(np.sum(part)) for part in motion)):
                refuse_jump(self.unstretched_length - base, payout_start, self.time)
            raise BadMotionError(
                f"at t = {self.time:g} s: boom tip and payout must be finite and the duration positive; got "
                f"{[part.tolist() for part in motion]}, {[payout_start, *ends[1:]]}, {duration}"
            )
        if outcome == at.TOO_SHORT:
            shortest = at.MERGE_AT * float(self._line.grid_points[1])
            raise CableTooShortError(
                f"at t = {self.time:g} s: {self.unstretched_length:g} m of cable is left, and the last segment "
                f"cannot be shorter than {shortest:g} m: haul in less or use more segments"
            )
        raise NotConvergedError(
            f"at t = {self.time:g} s: no solution was found even with the smallest steps; top tension "
            f"{self.top_tension:g} N, unit at {self.unit_position.round(3).tolist()} m"
        )

    # --- the state at the end of the last interval

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return float(self._line.numbers[at.NOW + at.TIME])

    @property
    def arrays(self) -> LineArrays:
        """The line as the kernels take it, its present state looked at."""
        self._observe()
        return self._line

    @property
    def segments(self) -> int:
        """Number of segments now."""
        return self._line.segments

    @property
    def newton_iterations(self) -> int:
        """Newton iterations since the start: what the computing time follows, on any machine."""
        return int(self._line.numbers[at.NEWTON])

    @property
    def node_positions(self) -> Array:
        """Positions [m], shape (N + 1, 3); row 0 the unit, row N the top end."""
        return self._line.read(at.X, 3, self.segments + 1)

    @property
    def node_velocities(self) -> Array:
        """Velocities [m/s], shape (N + 1, 3)."""
        return self._line.read(at.VX, 3, self.segments + 1)

    @property
    def material_coordinates(self) -> Array:
        """Unstretched length from the unit to each node [m], shape (N + 1,)."""
        return np.append(self._line.column(at.START, self.segments), self.unstretched_length)

    @property
    def segment_tensions(self) -> Array:
        """Tension of each segment [N], shape (N,), from the unit upwards; 0 where slack."""
        return self.nodes_and_tensions()[1]

    def nodes_and_tensions(self) -> tuple[Array, Array]:
        """Return `node_positions` and `segment_tensions`, quicker than one by one."""
        n = self.segments
        positions, tensions = np.empty((n + 1, 3)), np.empty(n)
        snapshot(*self._line, positions, tensions)
        return positions, tensions

    @property
    def top_force(self) -> Array:
        """Force of the line on its top end [N], shape (3,).

        It is the top segment's tension with half its weight, drag and inertia.
        """
        return self._seen(at.SEEN_FX, 3)

    @property
    def top_tension(self) -> float:
        """Size of `top_force` [N]; 0 where the line would have to push."""
        return self._seen_number(at.SEEN_TENSION)

    @property
    def largest_top_tension(self) -> float:
        """Largest `top_tension` at the ends of the steps of the last interval [N]: a snap passes between two ticks."""
        return self._seen_number(at.SEEN_LARGEST)

    def unit_motion(self) -> tuple[Array, Array, Array]:
        """Return `unit_position`, `unit_velocity` and `unit_acceleration`, quicker than one by one."""
        place = self._line.tiles[0, at.X : at.AX : at.STRIDE].copy()
        return place[:3], place[3:], self.unit_acceleration

    @property
    def unit_position(self) -> Array:
        """Position of the unit [m], shape (3,)."""
        return self._line.tiles[0, at.X : at.VX : at.STRIDE].copy()

    @property
    def unit_velocity(self) -> Array:
        """Velocity of the unit [m/s], shape (3,)."""
        return self._line.tiles[0, at.VX : at.AX : at.STRIDE].copy()

    @property
    def unit_acceleration(self) -> Array:
        """Acceleration of the unit [m/s^2], shape (3,): what its forces give it now.

        That of the time integration belongs to another moment of the step.
        """
        return self._seen(at.SEEN_AX, 3)

    @property
    def unstretched_length(self) -> float:
        """Unstretched length between unit and top end [m]."""
        return float(self._line.numbers[at.NOW + at.TOTAL])

    @property
    def largest_strain(self) -> float:
        """Largest strain of a segment [-]; negative where all are slack."""
        return self._seen_number(at.SEEN_STRAIN)

    @property
    def slack_segments(self) -> int:
        """Number of segments that carry no tension."""
        return int(self._seen_number(at.SEEN_SLACK))

    @property
    def is_on_seabed(self) -> bool:
        """Whether the unit or any of the cable lies on the seabed."""
        return self._clearance() < 0.0

    @property
    def touchdown(self) -> bool:
        """Whether the unit rests on the seabed."""
        return self.parameters.seabed.depth > 0.0 and self.height_above_seabed(self.unit_position) <= 0.0

    def height_above_seabed(self, position: Array) -> float:
        """Return how high a `position`, shape (3,) [m], is above the bottom [m], along z; negative below it."""
        return self._seabed.clearance(position, float(self._line.numbers[at.NOW + at.TIP_Z]))

    @property
    def touchdown_force(self) -> float:
        """Vertical force of the seabed on the unit, positive up [N]; 0 off the seabed."""
        return self._seen_number(at.SEEN_BED)

    @property
    def compensator_stroke(self) -> float:
        """How far the compensator's sheave is below its mid-stroke at the boom tip [m]; 0 without a compensator."""
        if self.parameters.compensator.stiffness == 0.0:
            return 0.0
        n = self.segments
        sheave = self._line.tiles[n >> at.SHIFT, at.Z + (n & at.LANES)]
        return float(self._line.numbers[at.NOW + at.TIP_Z] - sheave)

    def set_thrust(self, force: ArrayLike) -> None:
        """Set the thruster force on the unit [N], shape (3,), in place of `unit.thrust`, from now on."""
        thrust = np.array(force, dtype=float)
        if thrust.shape != (3,) or not np.all(np.isfinite(thrust)):
            raise BadMotionError(f"thrust must be three finite numbers [N]; got {thrust.tolist()}")
        rest = unit_properties(self.parameters).force - np.array(self.parameters.unit.thrust)
        for first in (at.UNIT_FORCE, at.DEEP + at.UNIT_FORCE):
            self._line.numbers[first : first + 3] = thrust + rest
        self._fresh = False

    def set_waves(self, waves: Waves) -> None:
        """Let `waves` act on cable and unit from now on, in place of those before.

        The rest at a start is that of still water. Where their ramp has not begun, nothing jumps.
        """
        self._waves, self._line = waves, with_waves(self._line, waves)
        self._fresh = False

    # --- inside

    def _seen(self, first: int, count: int) -> Array:
        self._observe()
        return self._line.numbers[first : first + count].copy()

    def _seen_number(self, index: int) -> float:
        self._observe()
        return self._line.numbers.item(index)

    def _observe(self) -> None:
        if not self._fresh:
            observe(self._line)
            self._fresh = True

    def _grow(self, total: float) -> None:
        """Let the grid reach beyond `total` [m]; rare, and the only allocation."""
        old, n = self._line, self.segments
        self._line = new = build_line(self.parameters, 2.0 * total)._replace(water=old.water)
        new.numbers[: at.GRID_END], new.numbers[at.NOW :] = old.numbers[: at.GRID_END], old.numbers[at.NOW :]
        new.write(at.X, old.read(at.X, at.NODE_COLUMNS, n + 1))
        new.write(at.PART, old.read(at.PART, at.PART_COLUMNS, n))
        new.write(at.HELD, old.read(at.HELD, 1, n))
        sheave = old.read(at.LUMP_MASS, at.PART_COLUMNS - at.SEGMENT_COLUMNS, n + 1)
        new.write(at.LUMP_MASS, sheave)

    def _rest(self, boom_tip: Array) -> None:
        """Let the line hang, or settle on the seabed where it would hang into it."""
        line = self._line
        line.numbers[at.BED_ON] = line.numbers[at.FRICTION_ON] = 0.0
        hang(line, boom_tip)
        line.numbers[at.BED_ON] = float(self.parameters.seabed.depth > 0.0)
        refuse_floating(float(self.unit_position[2]), float(boom_tip[2]))
        hold_here(line)
        if self.is_on_seabed:
            settle(line, self.parameters, boom_tip)
        hold_strains(line)
        line.numbers[at.FRICTION_ON] = float(self.parameters.cable.loss_factor > 0.0)

    def _start_compensator(self) -> None:
        spring = self.parameters.top_spring
        if spring.stiffness == 0.0:
            return
        self._line.numbers[at.SPRING_ON] = 1.0
        if spring.preload == 0.0:
            self._line.numbers[at.SPRING_PRELOAD] = -self.top_force[2]
            return
        # the sheave rests where the spring balances the line; the whole line hangs lower by as much
        stroke = (-self.top_force[2] - spring.preload) / spring.stiffness
        if abs(stroke) > 0.5 * spring.stroke:
            raise PlantError(
                f"compensator.preload = {spring.preload:g} N puts it {stroke:.2f} m from mid-stroke at rest, beyond "
                f"half its stroke of {spring.stroke:g} m; the static top tension is {-self.top_force[2]:.0f} N"
            )
        heights = self._line.read(at.Z, 1, self.segments + 1)
        self._line.write(at.Z, heights - stroke)
        if self.is_on_seabed:
            raise PlantError(
                f"compensator.preload = {spring.preload:g} N lets the line sink {stroke:.2f} m, into the seabed; 0 "
                "takes the static top tension"
            )
        hold_here(self._line)
        self._fresh = False

    def _clearance(self) -> float:
        """Return how far the lowest node is above the seabed [m], negative in it; infinite without one."""
        if self.parameters.seabed.depth == 0.0:
            return math.inf
        return min(map(self.height_above_seabed, self.node_positions[:-1]))


def _check_seabed(parameters: CableSimParameters) -> None:
    depth = parameters.seabed.depth
    if 0.0 < depth < 0.5 * parameters.length / parameters.segments:
        raise ParameterError(f"seabed.depth = {depth:g} m is less than half a segment: there is no room for the line")


def _regular_waves(wave: WaveKinematicsParameters) -> Waves:
    """Return the regular `wave`, whose crests pass the origin at time 0; none for another source."""
    if wave.source != "regular" or wave.amplitude == 0.0:
        return NO_WAVES
    omega = np.array([2.0 * math.pi / wave.period])
    return Waves(omega, omega, np.array([wave.amplitude]), np.zeros(1), np.array([wave.direction]))
