"""ROS shell of the winch controller."""

from __future__ import annotations

import dataclasses
import math
import time as wall
from collections.abc import Sequence
from typing import Any

from geometry_msgs.msg import TwistStamped
from heave_msgs.msg import TickStatus
from heave_msgs.srv import Redesign, SetMode
from heave_node.crane.pose import POSE_FIELDS, pose_of
from heave_node.errors import NodeError
from heave_node.interface import topics
from heave_node.interface.codes import (
    ALARMS,
    COMMANDS,
    COMPENSATION_LOST,
    LATE,
    MODE,
    MODE_CHANGED,
    RESTS_REQUESTED,
    SENSOR,
    SensorLevel,
    time_key,
    timed_message,
)
from heave_node.interface.sensors import SENSORS, Water
from heave_node.interface.topic import Topic
from heave_node.numerics.linear_model import ModelError
from heave_node.parameters import ParameterError
from heave_node.ros.diagnostics import Health, Level, alarm_health
from heave_node.ros.participant import ParticipantNode
from heave_node.ros.ports import Input
from heave_node.ros.process import run_process
from heave_node.tick.durations import Durations
from heave_node.tick.tick import Tick
from rcl_interfaces.msg import SetParametersResult
from rclpy.lifecycle import LifecycleState, TransitionCallbackReturn
from rclpy.parameter import Parameter
from rclpy.task import Future

from winch_controller_node.advice.messages import beliefs_of, observations_message
from winch_controller_node.advice.watch import AdviserWatch
from winch_controller_node.core.component import WinchController
from winch_controller_node.core.supervision.modes import ModeError
from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.design.wire import WireError, parameters_text
from winch_controller_node.in_front import motion_source
from winch_controller_node.interface import conversions
from winch_controller_node.interface.alarms import ALARMS as ALARM_TABLE
from winch_controller_node.interface.readings import Lateness, Measurements, Outputs, Report
from winch_controller_node.interface.sensors import INPUTS
from winch_controller_node.model.lqr import DesignError
from winch_controller_node.move_action import MoveAction
from winch_controller_node.node_parameters import WinchControllerParameters, load_chosen_parts
from winch_controller_node.redesign import Redesign as DesignBeside

ADVISER = "adviser"
"""Part of the diagnostics that says how the adviser answers."""
INACTIVE = "the controller is inactive: activate it first"

LEVELS = {SensorLevel.OK: Level.OK, SensorLevel.SUSPECT: Level.WARN, SensorLevel.LOST: Level.ERROR}


class WinchControllerNode(ParticipantNode):
    """Publishes in tick k the command for [t_k, t_{k+1}] from all readings delivered by t_k.

    It subscribes to sensors, to the joystick of an operator (`controller/operator_speed`), and to the adviser's answers
    (`controller/beliefs`) to its observations. Services `controller/set_mode`, `controller/redesign`; action
    `controller/move_to_depth`.
    """

    name = "winch_controller"
    parameters_type = WinchControllerParameters
    after = ("wave_vessel",)

    def __init__(self) -> None:
        super().__init__()
        self._redesign_wanted: tuple[DesignBeside, WinchControllerParameters, Future[None]] | None = None

    def on_build(self) -> None:
        """Make the controller, its outputs and inputs; a few ticks of a throw-away one warm everything up."""
        load_chosen_parts(self.parameters)
        self._begin()
        for tick in range(1, 4):
            self.controller.step(tick, Measurements())
        self._begin()
        self.outputs_of_tick: Outputs | None = None
        self.execution = Durations()
        self._reported: dict[str, list[str]] = {}
        self._changes: dict[str, str] = {}
        self.command = self.add_output(topics.WINCH_COMMAND)
        self.state = self.add_output(topics.CONTROLLER_STATE)
        self.kpi = self.add_output(topics.CONTROLLER_KPI)
        self.observations = self.add_output(topics.CONTROLLER_OBSERVATIONS)
        self.beliefs = self.add_input(topics.CONTROLLER_BELIEFS, check_stamps=False, settles=True)
        self.sensors = {name: self._add_measurement(SENSORS[name].topic, SENSORS[name].values) for name in INPUTS}
        self.winch_state = self._add_measurement(topics.WINCH_STATE, conversions.WINCH_STATE)
        self.preview = self.add_input(topics.HEAVE_PREVIEW, check_stamps=False, holds_ahead=True)
        self.crane_pose = self._add_measurement(topics.CRANE_POSE, POSE_FIELDS)
        self.create_service(SetMode, "controller/set_mode", self._serve_set_mode)
        self.create_service(Redesign, "controller/redesign", self._serve_redesign)
        self.add_on_set_parameters_callback(self._take_parameters)
        self.move = MoveAction(self, lambda: self.controller)
        self.create_subscription(TwistStamped, topics.OPERATOR_SPEED.name, self._take_operator_speed, 1)

    def _begin(self) -> None:
        """Begin with a new controller, the nominal of the parameters, and without an answer."""
        self.controller = self._make_controller()
        self.source = motion_source(self.controller, self.run.tick_period)
        self._nominal = parameters_text(self.parameters)
        self.adviser = AdviserWatch(self.run.tick_period)

    @property
    def _has_adviser(self) -> bool:
        return topics.CONTROLLER_BELIEFS.publisher in self.run.participants

    def _add_measurement(self, topic: Topic, fields: Sequence[str]) -> Input:
        """Read numbers of a sensor; its stamps are left to the controller's own gates, which want to see wrong ones."""
        return self.add_input(topic, fields, check_stamps=False, holds_ahead=True)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Start again in a run that is under way; `state` is the lifecycle state before."""
        if self.has_started:
            try:
                self._begin()
            except NodeError as error:
                self.fail(str(error), error)
                return TransitionCallbackReturn.FAILURE
            if self.tick is not None:
                self.controller.skip_programme(self.tick.time)
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Give no command from now on: the winch stops by its watchdog. `state` is the lifecycle state before."""
        self.move.abort("the controller was deactivated")
        return super().on_deactivate(state)

    def on_reset(self) -> None:
        """Start again: at standby, without an estimate."""
        self._begin()
        self.move.abort("the run was reset")

    def on_tick(self, tick: Tick) -> None:
        """Step the controller with what was delivered by `tick`."""
        self._take_redesign()
        delivered = {name: self.take(port) for name, port in self.sensors.items()}
        states = self.take(self.winch_state)
        winch = conversions.winch_reading_of(states[-1]) if states else None
        water = Water(self.parameters.water_density, self.parameters.gravity)
        previews = self.take(self.preview)
        preview = conversions.heave_preview(previews[-1]) if previews else None
        lateness = Lateness(self.punctuality.of_clock, self.punctuality.of_node)
        poses = [pose_of(reading) for reading in self.take(self.crane_pose)]
        measurements = conversions.measurements(delivered, winch, water, preview, lateness)
        answers = self.take(self.beliefs)
        began = wall.perf_counter()
        for answer in answers:
            if self.adviser.is_due(answer.asked, tick.number):
                self._hear(answer)
        outputs = self.source.step(tick.number, measurements, poses)
        execution = wall.perf_counter() - began
        self.execution.add(execution)
        self.outputs_of_tick = outputs
        stamp = tick.start_nanoseconds
        self.command.publish(conversions.command_message(outputs.order, stamp))
        # a bag of a lockstep run says nothing of the machine
        reported = math.nan if self.run.is_lockstep else execution
        self.state.publish(conversions.state_message(outputs.report, stamp, reported))
        kpi = outputs.kpi
        if kpi is not None:
            self.kpi.publish(conversions.kpi_message(kpi, stamp))
        observed = outputs.observations
        if observed is not None:
            nominal = self._nominal
            self.observations.publish(observations_message(observed, nominal, stamp))
            if self._has_adviser:
                self.adviser.asked(tick.number)
        self._report(tick, outputs)
        self.move.on_tick(tick.time)
        # the order has left: what is not active yet is read now, and what becomes active next is made so
        for answer in answers:
            if not self.adviser.is_due(answer.asked, tick.number):
                self._hear(answer)
        self.controller.settle()

    def on_left_out(self, tick: Tick) -> None:
        """See ParticipantNode: the estimate is predicted over a `tick` that is jumped over, and no command is given."""
        if self.is_active:
            self._note_requests(tick, self.controller.leave_out(tick.number))

    def _hear(self, answer: Any) -> None:
        """Take an answer of the adviser; one that comes too late or makes no sense is refused and counted."""
        try:
            beliefs = beliefs_of(answer)
        except WireError as error:
            self.adviser.refused(str(error))
            return
        if not self.adviser.is_question(beliefs.asked):
            self.adviser.refused_stale()
        elif self.controller.take(beliefs):
            self.adviser.took(beliefs.number)
        else:
            self.adviser.refused_late()

    def _report(self, tick: Tick, outputs: Outputs) -> None:
        """Log the alarms of a tick, and keep them with the requests for diagnostics."""
        time = time_key(tick.time)
        for alarm in (*outputs.alarms, *self.adviser.step(tick.number)):
            self.get_logger().warning(f"{time}: {alarm}")
            if alarm.code in (MODE_CHANGED, COMPENSATION_LOST):  # a part of its own
                self._changes[time] = "{mode}: {reason}".format_map(alarm.values)
            else:
                self._reported.setdefault(time, []).append(str(alarm))
        self._note_requests(tick, outputs.requests)

    def _note_requests(self, tick: Tick, requests: Sequence[str]) -> None:
        """Keep for diagnostics what the controller found requested at a `tick`."""
        if requests:
            self.note_request(tick.time, ", ".join(requests))

    def on_exit(self) -> None:
        """End without waiting for a design that nobody takes any more."""
        if self._redesign_wanted is not None:
            self._redesign_wanted[0].close()

    def diagnose(self) -> list[Health]:
        """Publish the state of each sensor, the mode, its reason, the solver's state, and what was reported since."""
        if self.outputs_of_tick is None:
            return [Health(MODE, Level.OK, self.controller.mode.value)]
        report = self.outputs_of_tick.report
        text = f"{report.mode}: {report.reason}" if report.reason else report.mode
        depth = f"{self.controller.depth:.3f}"
        changes, self._changes = self._changes, {}
        values = {"authority": f"{report.authority:.2f}", "mean depth [m]": depth, **changes}
        parts = [Health(MODE, _level_of(report), text, values)]
        parts.append(self._diagnose_commands())
        if self._has_adviser:
            level = Level.OK if self.adviser.is_well else Level.WARN
            parts.append(Health(ADVISER, level, self.adviser.words, self.adviser.values))
        for sensor in report.sensors:
            values = {"accepted": str(sensor.accepted), "rejected": str(sensor.refused)}
            text = str(sensor.alarm) if sensor.alarm else sensor.reason or "ok"
            parts.append(Health(f"{SENSOR} {sensor.sensor}", LEVELS[sensor.level], text, values))
        preview = self.controller.preview
        if preview.has_come:
            parts.append(Health("preview", Level.WARN if preview.fault else Level.OK, preview.words))
        for name, (is_well, words) in self.source.health().items():
            parts.append(Health(name, Level.OK if is_well else Level.WARN, words))
        if report.solver_status.startswith("not solved"):
            parts.append(alarm_health("solver", ALARM_TABLE.alarm("SOLVER_FAILED", status=report.solver_status)))
        reported, self._reported = {time: "; ".join(words) for time, words in self._reported.items()}, {}
        parts.append(Health(ALARMS, Level.WARN, timed_message(reported), reported) if reported else Health(ALARMS))
        return parts

    def on_run_ended(self, status: TickStatus) -> None:
        """Log the execution times of the run: in lockstep they are said nowhere else, whatever the `status`."""
        del status
        self.get_logger().info(f"execution time of a tick: {self.execution.words()}")

    def _diagnose_commands(self) -> Health:
        """Say how many commands the winch took late."""
        commands = self.controller.late_commands
        values = {LATE: str(commands.late), "known": str(commands.known), "largest [s]": f"{commands.largest:.2f}"}
        text = f"{commands.late} of {commands.known} commands took effect later than modelled"
        text += f", by up to {commands.largest:.2f} s" if commands.late else ""
        return Health(COMMANDS, Level.WARN if commands.is_reported else Level.OK, text, values)

    def _make_controller(self) -> WinchController:
        try:
            return WinchController(
                self.parameters,
                tick_period=self.run.tick_period,
                seed=self.run.seed,
            )
        except (DesignError, ModelError) as error:
            raise NodeError(str(error)) from error

    def _take_parameters(self, changes: Sequence[Parameter[Any]]) -> SetParametersResult:
        """Take what may be changed while the controller runs, the factor; ROS refuses all others itself."""
        try:
            for change in changes:
                if change.name == "factor":
                    self.controller.set_factor(change.value)
                    self.parameters = dataclasses.replace(self.parameters, factor=float(change.value))
        except ParameterError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _take_operator_speed(self, twist: TwistStamped) -> None:
        """Take an operator's speed: linear.z, positive up as all heave, so that pulling up lifts the unit [m/s]."""
        try:
            self.controller.operate(-twist.twist.linear.z)
        except ModeError as error:
            self.get_logger().warning(str(error), throttle_duration_sec=5.0)

    def _serve_set_mode(self, request: SetMode.Request, response: SetMode.Response) -> SetMode.Response:
        if not self.is_active:
            response.message = INACTIVE
            return response
        try:
            response.message = self.controller.ask_for_mode(
                request.mode, request.tension, consent=request.accept_unproved
            )
            response.success = True
        except ModeError as error:
            response.message = str(error)
        return response

    async def _serve_redesign(self, request: Redesign.Request, response: Redesign.Response) -> Redesign.Response:
        if not self.is_active:
            response.message = INACTIVE
            return response
        old = self.controller.nominal
        asked = (request.significant_wave_height, request.peak_period, request.length)
        if not all(math.isfinite(value) and value >= 0.0 for value in asked):
            response.message = "significant_wave_height, peak_period and length must be at least 0"
            return response
        # what is not given stays as assumed: the controller follows the sea by its own motion reference unit
        sea = dataclasses.replace(
            old.sea,
            significant_wave_height=request.significant_wave_height or old.sea.significant_wave_height,
            peak_period=request.peak_period or old.sea.peak_period,
        )
        new = dataclasses.replace(old, sea=sea, length=request.length or old.length)
        try:
            design = await self._redesign(new)
        except ValueError as error:
            response.message = str(error)
            return response
        response.success = True
        response.predicted_unit_sigma = self.controller.predicted_unit_sigma()
        response.message = (
            f"length {design.length:g} m: a = {design.cable.a:.4g} s^2, b = {design.cable.b:.4g} s, predicted unit "
            f"heave, standard deviation {response.predicted_unit_sigma:.4g} m"
        )
        return response

    async def _redesign(self, parameters: WinchControllerParameters) -> ControllerDesign:
        """Design beside the ticks, in real time, and return the design once it is active."""
        if self.run.is_lockstep:
            return self.controller.redesign(parameters)
        if self._redesign_wanted is not None:
            raise ModeError("another redesign is in progress")
        controller = self.controller
        in_force: Future[None] = Future()
        beside = DesignBeside(controller.under(parameters), controller.mean.point.payout, self.run.tick_period)
        self._redesign_wanted = (beside, parameters, in_force)
        await in_force
        return self.controller.design

    def _take_redesign(self) -> None:
        """Activate a prepared design between two ticks."""
        if self._redesign_wanted is None:
            return
        beside, nominal, in_force = self._redesign_wanted
        try:
            prepared = beside.take()
            if prepared is None:
                return
            self.controller.take_redesign(prepared, nominal)
            in_force.set_result(None)
        except ValueError as error:
            in_force.set_exception(error)
        self._redesign_wanted = None


def _level_of(report: Report) -> Level:
    """Return how grave the mode of a `report` is."""
    # standing by after harm is not rest
    if report.is_inhibited:
        return Level.ERROR
    if report.reason in RESTS_REQUESTED:
        return Level.OK
    is_stopped = report.mode in ("stopped", "emergency_stop", "stopping")
    return Level.ERROR if is_stopped else Level.WARN if report.mode == "fade_out" else Level.OK


def main() -> None:
    """Run the node until its run ends."""
    run_process(WinchControllerNode)


if __name__ == "__main__":
    main()
