"""The ROS shell of the sea and vessel."""

from __future__ import annotations

from heave_node.crane.pose import pose_message, pose_to_wire
from heave_node.errors import NodeError
from heave_node.interface import topics
from heave_node.interface.codes import MruStatus
from heave_node.interface.faults import FaultSchedule
from heave_node.interface.messages import SensorMessages
from heave_node.interface.sensors import MRU, STANDARD_WATER
from heave_node.ros.diagnostics import Health, Level, alarm_health
from heave_node.ros.fault_service import FaultService
from heave_node.ros.participant import ParticipantNode
from heave_node.ros.ports import Input
from heave_node.ros.process import run_process
from heave_node.tick.tick import Tick

from wave_vessel_node import conversions as messages
from wave_vessel_node.alarms import ALARMS
from wave_vessel_node.component import WaveVessel, WaveVesselOutputs
from wave_vessel_node.parameters import WaveVesselParameters

_MRU_SILENCE = 1.0  # s without a reading that diagnostics calls an error


class WaveVesselNode(ParticipantNode):
    """Publishes in tick k the MRU reading delivered at t_k, and the boom tip, vessel and surface at t_{k+1};
    with `preview.time` above 0 also a preview of the boom tip from t_k on, with a crane its pose at t_k.

    Service `wave_vessel/inject_fault` makes the MRU, or the crane's encoders, misbehave from the next tick on.
    """

    name = "wave_vessel"
    parameters_type = WaveVesselParameters
    tension: Input | None = None  # of the cable, where the ship responds to it

    def __init__(self) -> None:
        super().__init__()
        self.starts_ahead = not self.parameters.load_response.displacement  # then it reads the tension

    def on_build(self) -> None:
        """See HeaveNode. Compiles the sum of components by asking for the first motion."""
        self.on_reset()
        self.sea_state = self.add_output(topics.SEA_STATE)
        self.waves = self.add_output(topics.WAVE_COMPONENTS)
        self.estimate = self.add_output(topics.SEA_STATE_ESTIMATE)
        self.elevation = self.add_output(topics.WAVE_ELEVATION)
        self.odometry = self.add_output(topics.VESSEL_ODOMETRY)
        self.boom_tip = self.add_output(topics.BOOM_TIP)
        self.mru = self.add_output(MRU.topic)
        previews = self.parameters.preview.time > 0.0
        self.preview = self.add_output(topics.HEAVE_PREVIEW) if previews else None
        crane = self.parameters.crane
        self.crane = self.add_output(topics.CRANE_POSE) if crane.is_fitted and crane.pose.fitted else None
        if not self.starts_ahead:
            self.tension = self.add_input(topics.CABLE_STATE, ("top_tension",), holds_ahead=True)
        self._mru_messages = SensorMessages(MRU)
        FaultService(self, self._faults)

    def on_reset(self) -> None:
        """See HeaveNode."""
        self.component = self._new_component()
        self._prepared: WaveVesselOutputs | None = None
        self._last_reading_time = 0.0
        self._last_status: int = MruStatus.OK

    def on_tick(self, tick: Tick) -> None:
        """See HeaveNode."""
        if tick.number == 1:
            self.sea_state.publish(messages.sea_state_message(self.component.sea_state(), tick.start_nanoseconds))
            self.waves.publish(messages.waves_message(self.component.waves()))
        if self.tension is not None:
            self.take(self.tension)
        outputs = self._outputs_of(tick)
        reading = outputs.mru
        if reading is not None:
            self.mru.publish(self._mru_messages.message(MRU.to_wire(reading, STANDARD_WATER)))
            self._last_reading_time, self._last_status = tick.time, reading.status
        if self.preview is not None and outputs.preview is not None:
            self.preview.publish(messages.preview_message(outputs.preview, self.parameters.preview.noise))
        if self.crane is not None:
            for pose in outputs.crane:
                self.crane.publish(pose_message(pose_to_wire(pose)))
        end = tick.end_nanoseconds
        self.boom_tip.publish(messages.boom_tip_message(outputs.boom_tip, end))
        self.odometry.publish(messages.odometry_message(outputs.vessel, outputs.row, end))
        self.elevation.publish(messages.elevation_message(outputs.wave_elevation, end))
        if outputs.estimate is not None:
            stamp = round(outputs.estimate.time * 1e9)
            self.estimate.publish(messages.estimate_message(outputs.estimate, stamp))

    def on_inactive_tick(self, tick: Tick) -> None:
        """See ParticipantNode. The sea goes on."""
        self._outputs_of(tick)

    on_left_out = on_inactive_tick

    def prepare(self, number: int) -> None:
        """See ParticipantNode. A sea without a load waits for nobody, and the controller need not wait for the sea."""
        if self.tension is None:
            self._prepared = self.component.step(number)

    @property
    def next_tick(self) -> int:
        """See HeaveNode."""
        return super().next_tick + (self._prepared is not None)

    def _outputs_of(self, tick: Tick) -> WaveVesselOutputs:
        outputs, self._prepared = self._prepared, None
        if outputs is not None:
            return outputs
        newest = None if self.tension is None else self.tension.latest
        return self.component.step(tick.number, *([] if newest is None else newest.numbers[:1]))

    def diagnose(self) -> list[Health]:
        """Tell how the MRU is, and what was repaired in the files read."""
        assert self.tick is not None
        silence = self.tick.time - self._last_reading_time
        health = [Health("mru")]
        if silence > _MRU_SILENCE:
            health = [alarm_health("mru", ALARMS.alarm("MRU_OUTPUT_STOPPED", time=silence))]
        elif self._last_status != MruStatus.OK:
            health = [alarm_health("mru", ALARMS.alarm("MRU_OUTPUT_SETTLING"))]
        fit = self.component.vessel_fit
        if fit is not None:
            vessel = fit.vessel
            values = {
                "natural_frequency": f"{vessel.natural_frequency:.4f}",
                "damping_ratio": f"{vessel.damping_ratio:.4f}",
                "gain": f"{vessel.gain:.4f}",
                "relative_error": f"{fit.relative_error:.4f}",
            }
            health.append(Health("vessel", Level.OK, "second order, fitted to the RAO", values))
        if self.component.warnings:
            repaired = ALARMS.alarm("FILE_REPAIRED", warnings="; ".join(self.component.warnings))
            health.append(alarm_health("files", repaired))
        return health

    def _faults(self) -> dict[str, FaultSchedule]:
        """Return the faults of the devices that it simulates, by their names."""
        pose = self.component.pose_sensor
        return {"mru": self.component.mru.faults} | ({} if pose is None else {"crane": pose.faults})

    def _new_component(self) -> WaveVessel:
        try:
            component = WaveVessel(self.parameters, seed=self.run.seed, tick_period=self.run.tick_period)
        except ValueError as error:
            raise NodeError(str(error)) from error
        for warning in component.warnings:
            self.get_logger().warning(warning)
        return component


def main() -> None:
    """Run the node until its run ends."""
    run_process(WaveVesselNode)


if __name__ == "__main__":
    main()
