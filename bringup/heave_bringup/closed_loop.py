"""The whole loop in one process, without ROS: sea and vessel, winch, cable and unit, sensors, controller.

The same components as the nodes', in the order of the tick protocol, for campaigns, design studies and tests. Readings
are handed over as they travel, see `heave_node.interface.sensors`: the loop over ROS gives the same numbers, to the
last bit.
"""

from __future__ import annotations

import gc
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from cable_sim_node.component import CableSim
from cable_sim_node.node_parameters import CableSimNodeParameters
from cable_sim_node.sensors.suite import SensorReadings
from cable_sim_node.winch.command_line import WinchCommand
from cable_sim_node.winch.component import VirtualWinch
from cable_sim_node.winch.parameters import WinchParameters
from heave_node.crane.pose import pose_of, pose_to_wire
from heave_node.interface.alarm import Alarm
from heave_node.interface.sensors import MRU, STANDARD_WATER, Water, all_to_wire
from heave_node.numerics.arrays import Array
from wave_vessel_node.component import WaveVessel, WaveVesselOutputs
from wave_vessel_node.parameters import WaveVesselParameters
from winch_controller_node.adviser.component import Adviser
from winch_controller_node.core.component import WinchController
from winch_controller_node.in_front import motion_source
from winch_controller_node.interface.conversions import measurements, winch_reading
from winch_controller_node.interface.readings import Measurements, Outputs
from winch_controller_node.node_parameters import WinchControllerParameters

from heave_bringup.scenarios import Scenario

COLUMNS = (
    *("time", "boom_tip", "unit", "uncompensated", "payout", "payout_rate", "payout_acceleration", "top_tension"),
    *("largest_top_tension", "authority", "depth_set_point", "touchdown_force", "unit_rate"),
    *("uncompensated_tension", "uncompensated_largest_tension", "slack_segments", "limits_hit", "unit_tension"),
)


@dataclass(frozen=True)
class LoopParameters:
    """Parameters of the loop in one process."""

    sea: WaveVesselParameters  # of the components
    plant: CableSimNodeParameters  # of the components
    winch: WinchParameters  # of the components
    controller: WinchControllerParameters  # of the components
    tick_period: float = 0.05  # [s]
    duration: float = 600.0  # [s]
    seed: int = 1  # of every random number


@dataclass
class LoopRecord:
    """What a run left: one row per tick (t_k), columns by name, and the changes of mode."""

    rows: Array  # shape (ticks, len(COLUMNS)), SI units, heave positive up
    modes: list[str] = field(default_factory=list)  # mode at each tick
    alarms: list[tuple[float, Alarm]] = field(default_factory=list)  # time [s] and alarm

    def column(self, name: str, *, after: float = 0.0) -> Array:
        """Return the column `name`, one of COLUMNS, of the record from a time `after` [s] on."""
        first = np.searchsorted(self.rows[:, 0], after)
        return self.rows[first:, COLUMNS.index(name)].copy()

    def unit_sigma(self, after: float) -> float:
        """Standard deviation of the unit's heave from the time `after` [s] on [m], less a moving mean depth."""
        return float(np.std(self.column("unit", after=after) + self.column("depth_set_point", after=after)))

    def uncompensated_sigma(self, after: float) -> float:
        """Standard deviation of the uncompensated unit's heave from the time `after` [s] on [m]."""
        return float(np.std(self.column("uncompensated", after=after)))


def loop_parameters(scenario: Scenario) -> LoopParameters:
    """Return a scenario as parameters of the loop in one process."""
    return LoopParameters(
        sea=scenario.parameters["wave_vessel"],
        plant=scenario.parameters["cable_sim"],
        winch=scenario.parameters["virtual_winch"],
        controller=scenario.parameters["winch_controller"],
        tick_period=scenario.run.tick_period,
        duration=scenario.run.duration,
        seed=scenario.run.seed,
    )


class ClosedLoop:
    """The loop; `step` does one tick.

    Parameters
    ----------
    parameters : of all components
    has_adviser : False leaves the adviser out, as `--replace winch_adviser=none` does

    Attributes
    ----------
    sea, plant, winch, controller, adviser : the components
    tick : number of the next tick, from 1
    """

    def __init__(self, parameters: LoopParameters, *, has_adviser: bool = True) -> None:
        seed, dt = parameters.seed, parameters.tick_period
        self._dt = dt
        self._parameters = parameters
        self.sea = WaveVessel(parameters.sea, seed=seed, tick_period=dt)
        self.plant = CableSim(parameters.plant, seed=seed, tick_period=dt)
        self.winch = VirtualWinch(parameters.winch, tick_period=dt, seed=seed)
        self.take_controller(WinchController(parameters.controller, tick_period=dt, seed=seed))
        self.adviser = Adviser(parameters.controller, tick_period=dt) if has_adviser else None
        self._assumed_water = Water(parameters.controller.water_density, parameters.controller.gravity)
        self.tick = 1
        self._boom_tip = self.sea.initial_boom_tip()
        self._mean_tip = parameters.sea.boom_tip_height

    def take_controller(self, controller: WinchController) -> None:
        """Go on with a `controller`, and what stands in front of it."""
        self.controller, self._source = controller, motion_source(controller, self._dt)

    def step(self) -> tuple[Outputs, Array]:
        """Do one tick; return what the controller gave and the row of the record."""
        tick = self.tick
        self.controller.settle()
        state, readings = self.plant.readings(tick)
        vessel = self.sea.step(tick, state.top_tension)
        if tick == 1:
            self.plant.set_waves(self.sea.waves())
        delivered = self._deliver(readings, vessel)
        poses = [pose_of(pose_to_wire(pose)) for pose in vessel.crane]
        outputs = self._source.step(tick, delivered, poses)
        if self.adviser is not None and (observed := outputs.observations) is not None:
            self.controller.take(self.adviser.advise(observed))
        row = np.array(
            [
                state.time,
                self._boom_tip.position[2] - self._mean_tip,
                state.unit.position[2],
                state.uncompensated.position[2],
                self.winch.state.payout,
                self.winch.state.payout_rate,
                self.winch.state.payout_acceleration,
                state.top_tension,
                state.largest_top_tension,
                outputs.authority,
                outputs.depth_set_point,
                state.touchdown_force,
                state.unit.velocity[2],
                state.uncompensated_tension,
                state.uncompensated_largest_tension,
                state.slack_segments,
                self.winch.state.limits_hit,
                state.segment_tensions[0],
            ]
        )
        command = WinchCommand(*outputs.order)
        winch = self.winch.step(tick, command, state.top_tension)
        self.plant.advance(tick, vessel.boom_tip, (winch.payout, winch.payout_rate), outputs.depth_set_point)
        self._boom_tip = vessel.boom_tip
        self.tick += 1
        return outputs, row

    def _deliver(self, readings: SensorReadings, vessel: WaveVesselOutputs) -> Measurements:
        """Return what the controller makes of the readings of this tick, as they would have travelled."""
        delivered = all_to_wire(readings, self.plant.water)
        if vessel.mru is not None:
            delivered[MRU.name] = [MRU.to_wire(vessel.mru, STANDARD_WATER)]
        # the state at t_k is that of the tick before; before the first tick there was none
        now = self.tick * round(self._dt * 1e9)
        winch = winch_reading(self.winch.state, now) if self.tick > 1 else None
        return measurements(delivered, winch, self._assumed_water, vessel.preview)

    def run(self, on_tick: Callable[[int, Outputs], None] | None = None) -> LoopRecord:
        """Run to the end; `on_tick` sees each tick's number and outputs."""
        ticks = round(self._parameters.duration / self._dt)
        record = LoopRecord(np.empty((ticks, len(COLUMNS))))
        # what is there already is not looked through for garbage again and again
        gc.freeze()
        try:
            for index in range(ticks):
                outputs, record.rows[index] = self.step()
                record.modes.append(outputs.mode)
                record.alarms += [(float(record.rows[index, 0]), alarm) for alarm in outputs.alarms]
                if on_tick is not None:
                    on_tick(self.tick - 1, outputs)
        finally:
            gc.unfreeze()
        return record
