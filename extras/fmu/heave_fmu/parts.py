"""The parts of the loop as FMUs hold them: a component with its messages in and out, stepped tick by tick.

A tick is done in the order of the tick protocol: controller, then winch and vessel, then plant. Where an instance is
stepped once a tick, its caller keeps that order. Where all are stepped together, STEPS times a tick with what was known
before (libcosim), each acts in the step of its own instant, and the order is kept as well. Time 0 is the first tick.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from operator import attrgetter

import numpy as np
from cable_sim_node.component import CableSim, PlantState
from cable_sim_node.conversions import (
    CABLE_SCALARS,
    DRUM_MOTION,
    POINT_MOTION,
    WINCH_COMMAND,
    WINCH_STATE,
    drum_motion_of,
    point_motion_of,
    winch_command_of,
)
from cable_sim_node.winch.component import VirtualWinch
from heave_bringup.closed_loop import LoopParameters
from heave_node.interface import topics
from heave_node.interface.sensors import MRU, SENSORS, STANDARD_WATER, Water, WireReading, all_to_wire
from heave_node.numerics.kinematics import PointMotion
from wave_vessel_node.component import WaveVessel, WaveVesselOutputs
from winch_controller_node.adviser.component import Adviser
from winch_controller_node.core.component import WinchController
from winch_controller_node.interface.conversions import WINCH_STATE as WINCH_MEASURES
from winch_controller_node.interface.conversions import measurements, winch_reading_of

from heave_fmu.messages import (
    CABLE_FIELDS,
    CONTROLLER_FIELDS,
    ODOMETRY_FIELDS,
    SHADOW,
    TENSIONS,
    fitted_sensors,
    point_fields,
    sensor_slots,
)
from heave_fmu.part import STEPS, Part

_winch_numbers = attrgetter(*WINCH_STATE)
_cable_scalars = attrgetter(*CABLE_SCALARS)


class PlantPart(Part):
    """Cable, unit and the sensors on them."""

    instant = 2.5 / STEPS

    def declare(self) -> None:
        """See Part."""
        self.add_input(topics.BOOM_TIP, point_fields(POINT_MOTION))
        self.add_input(topics.WINCH_STATE, DRUM_MOTION)
        self.add_input(topics.CONTROLLER_STATE, ("depth_set_point",))
        for sensor in fitted_sensors(self.parameters):
            self.add_output(sensor.topic, sensor.values, sensor_slots(sensor, self.parameters))
        self.add_output(topics.CABLE_STATE, CABLE_FIELDS)
        self.add_output(topics.UNIT_ODOMETRY, ODOMETRY_FIELDS)
        self.add_output(topics.UNIT_UNCOMPENSATED, point_fields(POINT_MOTION))
        self.add_output(SHADOW, TENSIONS)

    def start(self) -> None:
        """See Part. Where the sea acts on the cable, it is that of the same scenario."""
        loop = self.parameters
        self._plant = CableSim(loop.plant, seed=loop.seed, tick_period=loop.tick_period)
        if loop.plant.wave.source == "sea":
            self._plant.set_waves(WaveVessel(loop.sea, seed=loop.seed, tick_period=loop.tick_period).waves())
        self._put_out(1)

    def step(self, tick: int) -> list[str]:
        """See Part."""
        now = self.stamp(tick + 1)
        tip = self.inputs[topics.BOOM_TIP.name].newest(now)
        state = self.inputs[topics.WINCH_STATE.name].newest(now)
        programme = self.inputs[topics.CONTROLLER_STATE.name].newest(now)
        drum = None if state is None else drum_motion_of(state)
        self._plant.advance(
            tick,
            None if tip is None else point_motion_of(tip),
            None if drum is None else (float(drum.position[0]), float(drum.velocity[0])),
            None if programme is None else programme.numbers[0],
        )
        self._put_out(tick + 1)
        return []

    def _put_out(self, tick: int) -> None:
        """Put out the state of t_k, and the readings delivered then."""
        state, readings = self._plant.readings(tick)
        for name, delivered in all_to_wire(readings, self._plant.water).items():
            sensor = SENSORS[name]
            self.outputs[sensor.topic.name].publish(
                WireReading(reading.stamp, reading.numbers[: sensor.width]) for reading in delivered
            )
        self.send(topics.CABLE_STATE, tick, _cable_numbers(state))
        self.send(topics.UNIT_ODOMETRY, tick, _point_numbers(state.unit)[: len(ODOMETRY_FIELDS)])
        self.send(topics.UNIT_UNCOMPENSATED, tick, _point_numbers(state.uncompensated))
        self.send(SHADOW, tick, (state.uncompensated_tension, state.uncompensated_largest_tension))


def _cable_numbers(state: PlantState) -> list[object]:
    return [*_cable_scalars(state), state.segment_tensions[0]]


def _point_numbers(motion: PointMotion) -> list[float]:
    return np.concatenate((motion.position, motion.velocity, motion.acceleration)).tolist()  # type: ignore[no-any-return]


class WinchPart(Part):
    """The virtual winch: drive, brake, watchdog, encoder."""

    instant = 1.5 / STEPS

    def declare(self) -> None:
        """See Part."""
        self.add_input(topics.WINCH_COMMAND, WINCH_COMMAND)
        self.add_input(topics.CABLE_STATE, ("top_tension",))
        self.add_output(topics.WINCH_STATE, WINCH_STATE)

    def start(self) -> None:
        """See Part. The state at the first tick is there, but is no message: nobody has asked yet."""
        loop = self.parameters
        self._winch = VirtualWinch(loop.winch, tick_period=loop.tick_period, seed=loop.seed)
        self._tension = math.nan
        self.outputs[topics.WINCH_STATE.name].hold(WireReading(self.stamp(1), _winch_numbers(self._winch.state)))

    def step(self, tick: int) -> list[str]:
        """See Part."""
        now = self.stamp(tick)
        command = self.inputs[topics.WINCH_COMMAND.name].newest(now)
        tension = self.inputs[topics.CABLE_STATE.name].newest(now)
        self._tension = self._tension if tension is None else tension.numbers[0]
        state = self._winch.step(tick, None if command is None else winch_command_of(command), self._tension)
        self.send(topics.WINCH_STATE, tick + 1, _winch_numbers(state))
        return []


class VesselPart(Part):
    """Sea, vessel and motion reference unit."""

    instant = 1.5 / STEPS

    def declare(self) -> None:
        """See Part."""
        self.add_output(MRU.topic, MRU.values)
        self.add_output(topics.BOOM_TIP, point_fields(POINT_MOTION))
        self.add_output(topics.WAVE_ELEVATION, ("elevation",))

    def start(self) -> None:
        """See Part."""
        loop = self.parameters
        self._vessel = WaveVessel(loop.sea, seed=loop.seed, tick_period=loop.tick_period)
        self.send(topics.BOOM_TIP, 1, _point_numbers(self._vessel.initial_boom_tip()))
        self._put_out(1)

    def step(self, tick: int) -> list[str]:
        """See Part: the motions of t_{k+1}, which the tick has found, and the readings delivered then."""
        self.send(topics.BOOM_TIP, tick + 1, _point_numbers(self._found.boom_tip))
        self.send(topics.WAVE_ELEVATION, tick + 1, (self._found.wave_elevation,))
        self._put_out(tick + 1)
        return []

    def _put_out(self, tick: int) -> None:
        """Put out the readings delivered at t_k."""
        self._found: WaveVesselOutputs = self._vessel.step(tick)
        if self._found.mru is not None:
            self.outputs[MRU.topic.name].publish([MRU.to_wire(self._found.mru, STANDARD_WATER)])


class ControllerPart(Part):
    """The controller, with its adviser."""

    instant = 0.5 / STEPS

    def declare(self) -> None:
        """See Part."""
        loop = self.parameters
        self.add_input(MRU.topic, MRU.values)
        for sensor in fitted_sensors(loop):
            self.add_input(sensor.topic, sensor.values, sensor_slots(sensor, loop))
        self.add_input(topics.WINCH_STATE, WINCH_MEASURES)
        self.add_output(topics.WINCH_COMMAND, WINCH_COMMAND)
        self.add_output(topics.CONTROLLER_STATE, CONTROLLER_FIELDS)

    def start(self) -> None:
        """See Part."""
        loop = self.parameters
        self._controller = WinchController(loop.controller, tick_period=loop.tick_period, seed=loop.seed)
        self._adviser = Adviser(loop.controller, tick_period=loop.tick_period)
        self._water = Water(loop.controller.water_density, loop.controller.gravity)

    def step(self, tick: int) -> list[str]:
        """See Part."""
        now, water = self.stamp(tick), self._water
        sensors = [MRU, *fitted_sensors(self.parameters)]
        delivered = {sensor.name: self.inputs[sensor.topic.name].take(now) for sensor in sensors}
        state = self.inputs[topics.WINCH_STATE.name].newest(now)
        winch = None if state is None else winch_reading_of(state)
        outputs = self._controller.step(tick, measurements(delivered, winch, water))
        if (observed := outputs.observations) is not None:
            self._controller.take(self._adviser.advise(observed))
        self.send(topics.WINCH_COMMAND, tick, (getattr(outputs.order, name) for name in WINCH_COMMAND))
        self.send(topics.CONTROLLER_STATE, tick, (getattr(outputs, name) for name in CONTROLLER_FIELDS))
        return [str(alarm) for alarm in outputs.alarms]


PARTS: Mapping[str, Callable[[LoopParameters], Part]] = {
    "vessel": VesselPart,
    "plant": PlantPart,
    "winch": WinchPart,
    "controller": ControllerPart,
}
"""The parts by name."""
