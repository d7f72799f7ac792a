"""The parts of a controller: what each of them is for stands in its own module."""

from __future__ import annotations

from heave_core.law import ACTING, PROVING, SUPERVISING, WATCHING, Control, put
from heave_core.law_table import GIVEN
from heave_node.interface.alarm import Alarm
from heave_node.interface.codes import WinchLimit
from heave_node.interface.preview import HeavePreview

from winch_controller_node.beliefs.beliefs import Beliefs
from winch_controller_node.core.beliefs_in_force import BeliefsInForce
from winch_controller_node.core.design_in_force import DesignInForce
from winch_controller_node.core.envelope import OrderEnvelope
from winch_controller_node.core.estimation.loop_estimation import LoopEstimation
from winch_controller_node.core.estimation.loop_tick import LoopTick
from winch_controller_node.core.estimation.observation import Observer
from winch_controller_node.core.estimation.preview_watch import PreviewWatch
from winch_controller_node.core.loop_command import LoopCommand
from winch_controller_node.core.supervision.after_stop import AfterStop
from winch_controller_node.core.supervision.late_commands import LateCommands
from winch_controller_node.core.supervision.mode_machine import ModeMachine
from winch_controller_node.core.supervision.modes import Mode
from winch_controller_node.core.supervision.proofs import Proofs
from winch_controller_node.core.supervision.rolling_kpi import KpiWindow
from winch_controller_node.core.supervision.supervisor import Decision, Supervisor, WinchSituation
from winch_controller_node.core.supervision.watch.encoder_reflex import EncoderReflex
from winch_controller_node.core.supervision.watch.load_watch import LoadWatch, rope_strength
from winch_controller_node.core.supervision.watch.winch_watch import WinchWatch
from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.interface.readings import Measurements, Report, WinchOrder
from winch_controller_node.model.estimator import KalmanEstimator
from winch_controller_node.motion.operator_speed import OperatorSpeed
from winch_controller_node.motion.programme import Programme
from winch_controller_node.motion.trajectory import MeanPayout
from winch_controller_node.node_parameters import WinchControllerParameters

FAULT = [row.name for row in GIVEN.rows].index("fault")
"""Place of the fault that the winch has reported last in what a tick is given."""


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
        self._dt, self._second = tick_period, max(1, round(1.0 / tick_period))  # ticks of a second
        self._in_force = DesignInForce(parameters, tick_period=tick_period)
        design, law = self._in_force.design, self._in_force.law
        self._control = Control()  # a tick in the core
        self._estimation = LoopEstimation(design, self._control)
        self._supervisor = Supervisor(design, law, self._situation)
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
        self._command = LoopCommand(design, law, self._kpi, self._control)
        self._beliefs = BeliefsInForce(self._in_force, self._estimation, self._winch)
        self._encoder = EncoderReflex(tick_period)
        self._after_stop = AfterStop(tick_period)
        self.proofs = Proofs(parameters, design.cable, tick_period)  # of raw readings, before the brake opens
        self._control.take(PROVING, **self.proofs.records)
        self._control.take(WATCHING, **self._winch.records, **self._encoder.records)
        self._control.take(SUPERVISING, **self._supervisor.records, **self._estimation.records)
        acting = {**self.envelope.records, **self._load.records, "motion": self._estimation.motion.record}
        self._control.take(ACTING, motions=self._estimation.records["tick"]["motions"], **acting)
        self._alarms: list[Alarm] = []
        self._requests: list[str] = []
        self.preview = PreviewWatch(law.preview, tick_period=tick_period)  # whether one is used
        self._previews = False
        self._next_tick = 0
        self._measurements = Measurements()  # of the last tick
        self._preview: HeavePreview | None = None  # to be used in it
        self._given = WinchOrder(0, 0.0, 0.0, True)  # order of the last tick, in the controller's own count
        self._situated: tuple[LoopTick, WinchSituation] | None = None
        # design, beliefs and payout that the core goes by
        self._told: tuple[ControllerDesign | None, Beliefs | None, float] = None, None, 0.0
        put(self._control.active, {"payout_limit": WinchLimit.PAYOUT})
        self._tell()
        self._decided: Decision | None = None
        self._reported: tuple[int, Report] | None = None  # report that was made last, with its tick

    def _situation(self) -> tuple[LoopTick, WinchSituation] | None:
        """Return what the last tick and the winch in it are, as they were when this was first asked for; None: none."""
        if self._situated is None and self._next_tick > 0:
            winch, reason, seen = self._winch, self.envelope.reason, self._supervisor.records["seen"][0]
            transport, fault = winch.transport(), int(self._control.given[FAULT])
            self._situated = (
                self._estimation.tick,
                WinchSituation(
                    fault=fault,
                    fault_cause=winch.fault_cause(fault, self._measurements),
                    envelope="" if reason is None else reason.brief,
                    mean_payout=float(seen["mean_payout"]),
                    share=float(seen["share"]),
                    inhibition=transport.inhibition or self._encoder.inhibition,
                    is_reversed=self._encoder.is_unresolved,
                    proof_gate=self.proofs.gate,
                    cell_jumped=bool(seen["cell_jumped"]),
                ),
            )
        return self._situated

    def _tell(self) -> None:
        """Have the core go by the active design and beliefs, and by the weight at the mean payout."""
        was_design, was_beliefs, was_payout = self._told
        design, beliefs, payout = self._told = self.design, self._beliefs.beliefs, self.mean.point.payout
        is_same = design is was_design and beliefs is was_beliefs
        if is_same and payout == was_payout:
            return
        parameters, active = self.parameters, self._control.active
        active["static_tension"] = design.static_tension_at(parameters.length + payout)
        if is_same:
            return
        self._encoder.take_delay(self._command.time_of_another_count)
        self._winch.refer_to(parameters)
        identifies, swing = parameters.identifies_winch, self._command.settled_swing
        share, delay = beliefs.authority if identifies else 1.0, self._winch.tolerated_delay
        values = {"share": share, "tolerated_delay": delay, "settled_swing": swing, "identifies_winch": identifies}
        put(active, values)

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
