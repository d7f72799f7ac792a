"""The parts of a controller: what each of them is for stands in its own module."""

from __future__ import annotations

import math

from heave_node.interface.alarm import Alarm

from winch_controller_node.beliefs.beliefs import Beliefs
from winch_controller_node.core.beliefs_in_force import BeliefsInForce
from winch_controller_node.core.design_in_force import DesignInForce
from winch_controller_node.core.envelope import OrderEnvelope
from winch_controller_node.core.estimation.loop_estimation import LoopEstimation
from winch_controller_node.core.estimation.observation import Observer
from winch_controller_node.core.estimation.preview_watch import PreviewWatch
from winch_controller_node.core.loop_command import Beside, LoopCommand
from winch_controller_node.core.supervision.after_stop import AfterStop
from winch_controller_node.core.supervision.late_commands import LateCommands
from winch_controller_node.core.supervision.mode_machine import ModeMachine
from winch_controller_node.core.supervision.modes import Mode
from winch_controller_node.core.supervision.proofs import Proofs
from winch_controller_node.core.supervision.rolling_kpi import KpiWindow
from winch_controller_node.core.supervision.supervisor import Sensed, Supervisor
from winch_controller_node.core.supervision.watch.encoder_reflex import EncoderReflex
from winch_controller_node.core.supervision.watch.load_watch import LoadWatch, rope_strength
from winch_controller_node.core.supervision.watch.winch_watch import WinchWatch
from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.model.estimator import KalmanEstimator
from winch_controller_node.motion.operator_speed import OperatorSpeed
from winch_controller_node.motion.programme import Programme
from winch_controller_node.motion.trajectory import MeanPayout
from winch_controller_node.node_parameters import WinchControllerParameters


class ControllerParts:
    """The parts of a controller, made from its parameters.

    Parameters
    ----------
    parameters : the assumed plant, winch and sea, and how laws and modes act
    tick_period : [s]
    seed : taken like every component's; the controller itself draws no random number

    Raises DesignError where no controller can be designed from the parameters.
    """

    def __init__(
        self,
        parameters: WinchControllerParameters,
        *,
        tick_period: float,
        seed: int = 0,
    ) -> None:
        del seed
        self._dt = tick_period
        self._in_force = DesignInForce(parameters, tick_period=tick_period)
        design, law = self._in_force.design, self._in_force.law
        self._estimation = LoopEstimation(design)
        tick = self._estimation.core_tick
        sensed = Sensed(self._estimation.observer.addresses, tick.address, tick.depths_address)
        self._supervisor = Supervisor(design, law, sensed)
        self._winch = WinchWatch(design)
        # in front of the winch
        self.envelope = OrderEnvelope(parameters, design.cable, tick_period, f"the law {parameters.law}")
        self._load = LoadWatch(
            parameters.alarms,
            tick_period=tick_period,
            rope=rope_strength(parameters),
            travel=parameters.tension.travel,
        )
        self._programme = Programme(parameters.programme)
        self._operator = OperatorSpeed(parameters.operator, tick_period=tick_period)
        self._kpi = KpiWindow(parameters.kpi_window, tick_period=tick_period)
        self._command = LoopCommand(design, law, Beside(self._estimation.motion, self.envelope, self._kpi, self._load))
        self._sequence, self._weighed = 0, ((design, math.nan), math.nan)
        self._beliefs = BeliefsInForce(self._in_force, self._estimation, self._winch)
        self._encoder = EncoderReflex(tick_period)
        self._after_stop = AfterStop(tick_period)
        self.proofs = Proofs(parameters, design.cable, tick_period)  # of raw readings, before the brake opens
        self._has_lost_encoder = 0
        self._alarms: list[Alarm] = []
        self._requests: list[str] = []
        self.preview = PreviewWatch(law.preview, tick_period=tick_period)  # whether one is used
        self._previews = False
        self._next_tick = 0

    @property
    def parameters(self) -> WinchControllerParameters:
        """Active parameters."""
        return self._in_force.parameters

    @property
    def design(self) -> ControllerDesign:
        """Active design."""
        return self._in_force.design

    @property
    def modes(self) -> ModeMachine:
        """The mode machine."""
        return self._supervisor.modes

    @property
    def mode(self) -> Mode:
        """Mode after the last tick."""
        return self.modes.mode

    @property
    def mean(self) -> MeanPayout:
        """The mean payout, about which the winch compensates."""
        return self._estimation.motion.mean

    @property
    def estimator(self) -> KalmanEstimator:
        """The estimator of the loop, without the mean payout's own motion."""
        return self._estimation.estimator

    @property
    def observer(self) -> Observer:
        """The gates in front of the estimator."""
        return self._estimation.observer

    @property
    def depth(self) -> float:
        """Estimated mean depth of the unit, positive down [m]; NaN before the first depth reading."""
        return self._estimation.mean_depth

    @property
    def late_commands(self) -> LateCommands:
        """How many commands the winch took later than modelled."""
        return self._winch.late_commands

    @property
    def nominal(self) -> WinchControllerParameters:
        """Parameters as an operator has stated them."""
        return self._beliefs.nominal

    @property
    def beliefs(self) -> Beliefs:
        """Active beliefs."""
        return self._beliefs.beliefs

    @property
    def carried(self) -> float:
        """Payout by which the mean one has been carried along so far, beside its moves [m]."""
        return self._estimation.motion.carried.point.payout
