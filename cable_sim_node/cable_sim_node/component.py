"""The plant as a component: cable and unit, the same plant with the winch locked, and the sensors on them.

A tick k has two halves: `readings(k)` gives the state and the sensor readings of t_k = k tick_period, `advance(k,
...)` takes the boom tip and the payout at t_{k+1} and integrates to there. The plant rests at equilibrium below the
mean boom tip at t_1: hanging, or with unit and cable on the seabed where `length` reaches it.
"""

from __future__ import annotations

import copy
from typing import NamedTuple

import numpy as np
from heave_node.interface.sensors import Water
from heave_node.interface.waves import Waves
from heave_node.numerics.arrays import Array
from heave_node.numerics.kinematics import PointMotion
from heave_node.sensing.sensor import Sensor

from cable_sim_node.errors import BadMotionError, PlantError
from cable_sim_node.inputs import BridgedInput, ShadowPayout, is_finite
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.line.two_lines import TwoLines
from cable_sim_node.node_parameters import CableSimNodeParameters
from cable_sim_node.physics.seabed import Seabed
from cable_sim_node.sensors.instruments import SensorTruth
from cable_sim_node.sensors.suite import RopePath, SensorReadings, SensorSuite
from cable_sim_node.vertical.linear_plant import LinearPlant

Dynamics = CableDynamics | LinearPlant

LARGEST_START_GAP = 20.0
"""Largest distance between the first boom tip or payout and where the plant rests at the start [m]."""
IMPLAUSIBLE_SPEED = 20.0
"""An input that moves faster [m/s] is a false number, not a motion."""

NO_COMPONENTS = (
    "wave.source = sea, but this sea has no components, or none that last: take boom_tip_source = spectrum or regular "
    "without a later sea, a turn or change of speed, or another wave.source"
)
"""Why such a sea is refused."""


class PlantState(NamedTuple):
    """Truth of the plant at one time, frame `world` (z up)."""

    time: float  # simulated time [s]
    node_positions: Array  # shape (N+1, 3), node 0 is the unit, node N the boom tip [m]
    segment_tensions: Array  # shape (N,), from the unit upwards, never negative [N]
    top_tension: float  # force on the top end [N]
    largest_top_tension: float  # largest of it since the tick before [N]
    unstretched_length: float  # cable below the boom tip [m]
    slack_segments: int  # number of segments without tension
    touchdown: bool  # the unit or the cable touches the seabed
    touchdown_force: float  # vertical force of the seabed on the unit, positive up [N]
    compensator_stroke: float  # extension of a passive compensator [m]
    unit: PointMotion  # motion of the unit
    uncompensated: PointMotion  # motion of the unit of the shadow plant
    uncompensated_tension: float  # force on the top end of its cable, now [N]
    uncompensated_largest_tension: float  # the largest since the tick before [N]


class CableSim:
    """The plant.

    Parameters
    ----------
    parameters : plant and sensors
    seed : fixes the sensors' noise
    tick_period : [s]

    Attributes
    ----------
    tick : number k of the tick whose start the plant is at; 1 at first
    boom_tip, payout : the inputs as used, and how many values were missing
    water : that the unit is in
    largest_strain : of a segment of the cable so far [-]
    awaits_waves : the sea of the vessel is to act, and has not been set yet
    """

    def __init__(self, parameters: CableSimNodeParameters, *, seed: int, tick_period: float) -> None:
        self._parameters = parameters
        self._tick_period = tick_period
        start = np.array([0.0, 0.0, parameters.boom_tip_height])
        self.tick = 1
        self.boom_tip = BridgedInput("boom_tip", start, tick_period=tick_period)
        self.payout = BridgedInput("payout", np.zeros(1), tick_period=tick_period)
        # boom tip, and payout with its rate of drum and shadow, at the present tick
        self._last = (PointMotion(tick_period, start), (0.0, 0.0), (0.0, 0.0))
        self._plant = _at_rest(parameters, start, time=tick_period)
        self._shadow = copy.deepcopy(self._plant)
        self._shadow_payout = ShadowPayout(tick_period=tick_period)
        self.water = Water(parameters.water_density, parameters.gravity)
        self._static_top_tension = self._plant.top_tension
        self._rope_path = RopePath(parameters.rope_path, tension=self._static_top_tension)
        self.largest_strain = self._plant.largest_strain
        self.awaits_waves = parameters.wave.source == "sea"
        self._seabed = Seabed(parameters.seabed)
        self._suite = SensorSuite(parameters.sensors, seed=seed, tick_period=tick_period)

    @property
    def sensors(self) -> dict[str, Sensor]:
        """The sensors that are fitted, by name, to inject faults into."""
        return self._suite.by_name

    @property
    def waves_missing(self) -> int:
        """Ticks so far that the sea of the vessel should have acted in, and has not been set; 0 at the first."""
        return self.tick - 1 if self.awaits_waves else 0

    def state(self) -> PlantState:
        """Return the state of t_k, k the present `tick`."""
        plant = self._plant
        time = self.tick * self._tick_period
        positions, tensions = plant.nodes_and_tensions()
        return PlantState(
            time=time,
            node_positions=positions,
            segment_tensions=tensions,
            top_tension=plant.top_tension,
            largest_top_tension=plant.largest_top_tension,
            unstretched_length=plant.unstretched_length,
            slack_segments=plant.slack_segments,
            touchdown=plant.touchdown,
            touchdown_force=plant.touchdown_force,
            compensator_stroke=plant.compensator_stroke,
            unit=PointMotion(time, *plant.unit_motion()),
            uncompensated=PointMotion(time, *self._shadow.unit_motion()),
            uncompensated_tension=self._shadow.top_tension,
            uncompensated_largest_tension=self._shadow.largest_top_tension,
        )

    def readings(self, tick: int) -> tuple[PlantState, SensorReadings]:
        """Return the state of t_k and the sensor readings delivered at t_k; call once per tick, before `advance`.

        Raises PlantError where the plant is not at t_k.
        """
        self._check_tick(tick)
        state = self.state()
        truth = SensorTruth(
            position=state.unit.position,
            velocity=state.unit.velocity,
            acceleration=state.unit.acceleration,
            drum_tension=self._rope_path.drum_tension,
            static_top_tension=self._static_top_tension,
            gravity=self._parameters.gravity,
        )
        return state, self._suite.step(tick, truth)

    def set_waves(self, waves: Waves) -> None:
        """Let the sea of the vessel, its `waves`, act on cable and unit where `wave.source` is sea; else leave it out.

        Call it before the first `advance`: until then the water is still. Raises PlantError for a sea without
        components.
        """
        if self._parameters.wave.source != "sea":
            return
        if not len(waves.frequency):
            raise PlantError(f"cable_sim: {NO_COMPONENTS}")
        for dynamics in (self._plant, self._shadow):
            if isinstance(dynamics, CableDynamics):
                dynamics.set_waves(waves)
        self.awaits_waves = False

    def advance(
        self,
        tick: int,
        boom_tip: PointMotion | None,
        winch: tuple[float, float] | None,
        programme: float | None = None,
    ) -> None:
        """Integrate from t_k to t_{k+1}.

        Parameters
        ----------
        tick : k
        boom_tip : motion of the boom tip at t_{k+1}; None: missing, it coasts to rest until it comes again
        winch : payout [m] and its rate [m/s] at t_{k+1}; None: missing, likewise
        programme : payout that the shadow plant follows where shadow_follows_programme is set [m]

        Raises
        ------
        PlantError : the plant is not at t_k, the first boom tip or payout is nowhere near the start
            (BadMotionError), or whatever CableDynamics.advance raises.
        """
        self._check_tick(tick)
        tip, drum, shadow, start = self.boom_tip, self.payout, self._shadow_payout, self._last
        tip.advance(self._plausible(tip, boom_tip))
        drum.advance(self._plausible(drum, winch and PointMotion(0.0, *np.array([winch[:1], winch[1:], (0.0,)]))))
        if self._parameters.shadow_follows_programme:
            shadow.advance(programme)
        self.tick += 1
        end = self._last = (
            PointMotion(self.tick * self._tick_period, tip.position, tip.velocity, tip.acceleration),
            (drum.position.item(), drum.velocity.item()),
            (shadow.payout, shadow.rate),
        )
        self._plant.advance(self._tick_period, start[0], end[0], *start[1], *end[1])
        self._shadow.advance(self._tick_period, start[0], end[0], *start[2], *end[2])
        self._rope_path.advance(self._plant.top_tension, end[1][0])
        self.largest_strain = max(self.largest_strain, self._plant.largest_strain)

    def _check_tick(self, tick: int) -> None:
        if tick != self.tick:
            raise PlantError(f"cable_sim: tick {tick} was requested, but the plant is at tick {self.tick}")

    def _plausible(self, signal: BridgedInput, value: PointMotion | None) -> PointMotion | None:
        """Return `value`, or None where it moves faster than anything real.

        Raises BadMotionError where the first value is far from where the plant rests.
        """
        if value is None:
            return None
        step = max(map(abs, (value.position - signal.position).tolist()))
        if not signal.has_started and step > LARGEST_START_GAP and is_finite(value):
            raise BadMotionError(
                f"cable_sim: the first {signal.name} is {step:.1f} m from the rest position of the plant; "
                "boom_tip_height must be the same in cable_sim and wave_vessel, and payout counts from 0 at "
                "cable_sim's length"
            )
        largest_step = IMPLAUSIBLE_SPEED * self._tick_period * (signal.missing_in_a_row + 1)
        speed = max(map(abs, value.velocity.tolist()))
        is_fast = speed > IMPLAUSIBLE_SPEED or (signal.has_started and step > largest_step)
        return None if is_fast else value


def _at_rest(parameters: CableSimNodeParameters, boom_tip: Array, time: float) -> Dynamics:
    """Return the plant in equilibrium below the boom tip, at a `time` [s]."""
    dynamics: Dynamics
    if parameters.model == "linear":
        linear = parameters.linear
        dynamics = LinearPlant(parameters, inertia=linear.inertia, damping=linear.damping)
    else:
        dynamics = (TwoLines if parameters.second_line.length > 0.0 else CableDynamics)(parameters)
    dynamics.start_at_equilibrium(boom_tip, 0.0, time=time)
    return dynamics
