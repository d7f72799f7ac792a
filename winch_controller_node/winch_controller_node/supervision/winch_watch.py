"""Watching the winch: whether it behaves as its model says, and takes commands in time."""

from __future__ import annotations

from dataclasses import dataclass

from heave_node.codes import WinchLimit

from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.design.schedule import is_scheduled
from winch_controller_node.identification.winch import LateCommands, WinchIdentifier
from winch_controller_node.interface.readings import WinchOrder, WinchReading
from winch_controller_node.node_parameters import WinchControllerParameters

LEARNING_PERIOD, CHECKING_PERIOD = 2.0, 10.0
"""Time from one identification of the winch to the next [s], while its record grows and when that is full."""

TOLERATED_SHARE = 0.5
"""Further delay with which compensation is tried, over lag and delay of the model, where these are not identified."""

UNMODELLED_LIMITS = ~(WinchLimit.SPEED | WinchLimit.ACCELERATION)
"""Limits of a winch that its identification does not know."""


def identifies_winch(parameters: WinchControllerParameters) -> bool:
    """Tell whether the winch is identified while the loop runs: a speed servo, no gain schedule in `parameters`."""
    return parameters.lag.adaptation and not is_scheduled(parameters) and parameters.winch.law != "first_order"


@dataclass(frozen=True, slots=True)
class TransportReport:
    """How commands get to the winch.

    Attributes
    ----------
    alarm : what has just become wrong, in words; empty: nothing
    inhibition : why compensation must be off; empty: it need not
    """

    alarm: str = ""
    inhibition: str = ""


class WinchWatch:
    """Compares what the winch was sent with what it made of it.

    Parameters
    ----------
    design : with the model of the winch at the start
    """

    def __init__(self, design: ControllerDesign) -> None:
        self._dt = design.tick_period
        self._identifier = WinchIdentifier(design.parameters.lag, design)
        self._late_commands = LateCommands(design.tick_period)
        self._given: WinchOrder | None = None

    def give(self, order: WinchOrder) -> None:
        """Note the order of a tick."""
        self._given = order

    def improved_parameters(self, tick: int, parameters: WinchControllerParameters) -> WinchControllerParameters | None:
        """Return parameters with the winch as identified; None: the present ones are as good, or it is not the time.

        Parameters
        ----------
        tick : number of the present one
        parameters : in force
        """
        period = CHECKING_PERIOD if self._identifier.is_full else LEARNING_PERIOD
        if tick % max(1, round(period / self._dt)) != 0:
            return None
        return self._identifier.improved_parameters(parameters)

    def watch(
        self, winch: WinchReading | None, payout: float | None, parameters: WinchControllerParameters
    ) -> TransportReport:
        """Put the set-points of the last tick and what the encoder made of them on record; notice late commands.

        Parameters
        ----------
        winch : what the winch says of itself; None: nothing came
        payout : accepted encoder reading [m]; None: none
        parameters : with the model of the winch in force
        """
        given = self._given
        report = TransportReport()
        if given is not None and winch is not None:
            report = self._watch_transport(given.sequence, winch.command_sequence, parameters)
        if given is None or given.brake:
            self._identifier.reset(0.0 if given is None else given.payout)
        elif winch is not None and winch.limits_hit & UNMODELLED_LIMITS:
            self._identifier.add(given.payout, given.payout_rate, None)
            self._identifier.restart()
        else:
            self._identifier.add(given.payout, given.payout_rate, payout)
        return report

    def _watch_transport(self, given: int, taken: int, parameters: WinchControllerParameters) -> TransportReport:
        """Notice late commands; nothing is compensated with more delay than can be identified or tolerated."""
        winch = parameters.winch
        alarm = self._late_commands.update(given, taken, winch.command_delay)
        if alarm:
            self._identifier.restart()
        lag = winch.command_delay + winch.time_constant
        tolerated = parameters.lag.largest if identifies_winch(parameters) else TOLERATED_SHARE * lag
        overdue = self._late_commands.overdue
        if overdue <= tolerated:
            return TransportReport(alarm)
        return TransportReport(
            alarm, f"winch commands take effect {overdue:.2f} s later than modelled: too late for a stable loop"
        )
