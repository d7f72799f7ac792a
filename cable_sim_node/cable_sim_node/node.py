"""ROS shell of the plant: the clock master of a run."""

from __future__ import annotations

from heave_node.errors import NodeError
from heave_node.interface import topics
from heave_node.interface.messages import SensorMessages
from heave_node.interface.sensors import SENSORS, all_to_wire
from heave_node.numerics.constants import LARGEST_STRAIN
from heave_node.ros.diagnostics import Health, Level, alarm_health
from heave_node.ros.fault_service import FaultService
from heave_node.ros.master import ClockMasterNode
from heave_node.ros.process import run_process
from heave_node.tick.tick import Tick

from cable_sim_node import conversions
from cable_sim_node.alarms import ALARMS
from cable_sim_node.component import CableSim, PlantState
from cable_sim_node.errors import PlantError
from cable_sim_node.inputs import NewestMotion
from cable_sim_node.markers import plant_markers
from cable_sim_node.node_parameters import CableSimNodeParameters
from cable_sim_node.sensors.suite import SensorReadings

MARKERS_PERIOD = 0.5
"""Time from one set of markers to the next [s]."""


class CableSimNode(ClockMasterNode):
    """Publishes state and sensor readings of t_k; integrates to t_{k+1} with the boom tip and the payout of then."""

    name = "cable_sim"
    parameters_type = CableSimNodeParameters
    after = ("wave_vessel", "virtual_winch")

    def on_build(self) -> None:
        """Make the plant, the outputs and the inputs; one tick of a throw-away plant compiles the solver."""
        warm_up = self._make_plant()
        warm_up.readings(1)
        warm_up.advance(1, None, None)
        self.plant = self._make_plant()
        self.newest_tip, self.newest_payout = NewestMotion(), NewestMotion()
        self._strain_was_said = False
        self.state: PlantState | None = None
        self.sensor_outputs = {
            name: (self.add_output(SENSORS[name].topic), SensorMessages(SENSORS[name])) for name in self.plant.sensors
        }
        self.cable_state = self.add_output(topics.CABLE_STATE)
        self.unit_odometry = self.add_output(topics.UNIT_ODOMETRY)
        self.uncompensated = self.add_output(topics.UNIT_UNCOMPENSATED)
        self.markers = self.add_output(topics.MARKERS)
        self.boom_tip = self.add_input(topics.BOOM_TIP, conversions.POINT_MOTION)
        self.winch_state = self.add_input(topics.WINCH_STATE, conversions.DRUM_MOTION)
        # in a bag that is played from later on, the sea began before the run
        has_sea = self.parameters.wave.source == "sea"
        self.waves = self.add_input(topics.WAVE_COMPONENTS, check_stamps=False) if has_sea else None
        # only a shadow that is lowered needs it
        follows = self.parameters.shadow_follows_programme
        self.programme = self.add_input(topics.CONTROLLER_STATE, ("depth_set_point",)) if follows else None
        FaultService(self, lambda: {name: sensor.faults for name, sensor in self.plant.sensors.items()})

    def on_reset(self) -> None:
        """Start from rest again, without the faults that were injected."""
        self.plant = self._make_plant()
        self.newest_tip, self.newest_payout = NewestMotion(), NewestMotion()
        self._strain_was_said = False

    def on_readings(self, tick: Tick) -> None:
        """Publish the state of t_k, the time of `tick`, and the sensor readings delivered at t_k."""
        try:
            self.state, readings = self.plant.readings(tick.number)
        except PlantError as error:
            raise NodeError(str(error)) from error
        self._publish_sensors(readings)
        self._publish_state(self.state, tick)

    def _publish_sensors(self, readings: SensorReadings) -> None:
        """Publish what the sensors deliver; the controller waits for it."""
        for name, taken in all_to_wire(readings, self.plant.water).items():
            output, messages = self.sensor_outputs[name]
            for reading in taken:
                output.publish(messages.message(reading))

    def _publish_state(self, state: PlantState, tick: Tick) -> None:
        """Publish the truth, which only the virtual winch waits for."""
        stamp = tick.start_nanoseconds
        self.cable_state.publish(conversions.cable_state_message(state, stamp))
        self.unit_odometry.publish(conversions.unit_odometry_message(state.unit, stamp))
        self.uncompensated.publish(conversions.point_motion_message(state.uncompensated, stamp))
        if self._are_markers_due(tick):
            self.markers.publish(plant_markers(state, self.parameters.seabed, stamp))

    def on_advance(self, tick: Tick) -> None:
        """Integrate from `tick` k to t_{k+1} with what is here of then; what is missing is bridged and counted."""
        for reading in self.take(self.boom_tip):
            self.newest_tip.put(conversions.point_motion_of(reading))
        for reading in self.take(self.winch_state):
            self.newest_payout.put(conversions.drum_motion_of(reading))
        self._take_waves()
        end = tick.end_nanoseconds * 1e-9
        drum = self.newest_payout.at(end)
        try:
            self.plant.advance(
                tick.number,
                self.newest_tip.at(end),
                (float(drum.position[0]), float(drum.velocity[0])) if drum is not None else None,
                self._programme(),
            )
        except PlantError as error:
            raise NodeError(str(error)) from error

    def _take_waves(self) -> None:
        """Let the sea act that has come; in lockstep it must have come with the first tick."""
        if self.waves is None:
            return
        try:
            for message in self.take(self.waves):
                self.plant.set_waves(conversions.waves_of(message))
        except ValueError as error:
            raise NodeError(f"wave_components of wave_vessel: {error}") from error
        except PlantError as error:
            raise NodeError(str(error)) from error
        if self.plant.awaits_waves and self.run.is_lockstep:
            raise NodeError(
                "wave.source = sea, but no wave_components came with the first tick: wave_vessel must publish them, "
                "and a bag that is played in its place must hold them; else take another wave.source"
            )

    def _programme(self) -> float | None:
        """Return the payout of the controller's depth programme [m]; None where it is not needed."""
        if self.programme is None:
            return None
        self.take(self.programme)
        newest = self.programme.latest
        return None if newest is None else float(newest.numbers[0])

    def diagnose(self) -> list[Health]:
        """Say what of the inputs is missing and whether the cable is slack."""
        parts = []
        for signal in (self.plant.boom_tip, self.plant.payout):
            part, values = f"input {signal.name}", {"missing": str(signal.missing)}
            late = ALARMS.alarm("PLANT_INPUT_MISSING", name=signal.name, count=signal.missing_in_a_row)
            parts.append(alarm_health(part, late, values) if signal.missing_in_a_row else Health(part, values=values))
        if self.plant.waves_missing:  # what comes with the first tick is taken after its diagnostics
            late = ALARMS.alarm("PLANT_INPUT_MISSING", name="wave_components", count=self.plant.waves_missing)
            parts.append(alarm_health("input wave_components", late))
        return [*parts, self._cable_health()]

    def has_urgent_news(self) -> bool:
        """Whether the cable has just been strained too much: the run may end before diagnostics are due."""
        was_said, self._strain_was_said = self._strain_was_said, self.plant.largest_strain > LARGEST_STRAIN
        return self._strain_was_said and not was_said

    def _cable_health(self) -> Health:
        """Say that the cable is strained too much, which stays said, or slack."""
        strain = self.plant.largest_strain
        values = {"largest strain": f"{strain:.4f}"}
        if strain > LARGEST_STRAIN:
            overstrained = ALARMS.alarm("CABLE_OVERSTRAINED", percent=100.0 * strain, limit=100.0 * LARGEST_STRAIN)
            return alarm_health("cable", overstrained, values)
        slack = self.state.slack_segments if self.state is not None else 0
        if slack:
            return alarm_health("cable", ALARMS.alarm("CABLE_SEGMENTS_SLACK", count=slack), values)
        return Health("cable", Level.OK, "taut", values)

    def _make_plant(self) -> CableSim:
        try:
            return CableSim(self.parameters, seed=self.run.seed, tick_period=self.run.tick_period)
        except PlantError as error:
            raise NodeError(str(error)) from error

    def _are_markers_due(self, tick: Tick) -> bool:
        ticks: int = max(1, round(MARKERS_PERIOD / self.run.tick_period))
        return tick.number % ticks == 0


def main() -> None:
    """Run the node."""
    run_process(CableSimNode)


if __name__ == "__main__":
    main()
