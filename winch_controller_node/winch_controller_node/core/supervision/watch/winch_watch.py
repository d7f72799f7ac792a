"""Watching the winch: whether it does what is predicted of it, and takes commands in time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from heave_node.interface.alarm import Alarm
from heave_node.interface.codes import WinchFault, WinchLimit

from winch_controller_node.beliefs.beliefs import CAUTIOUS
from winch_controller_node.core.supervision.late_commands import CUT_TIME, LateCommands
from winch_controller_node.core.supervision.watch.drum_watch import DrumWatch
from winch_controller_node.core.supervision.watch.timeout_cause import TimeoutCause
from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.interface.readings import Lateness, WinchOrder, WinchReading
from winch_controller_node.node_parameters import WinchControllerParameters

TOLERATED_SHARE = 0.5
"""Further delay with which compensation is tried, over lag and delay of the model, where these are not identified."""

ALARMING = 0.04
"""Error of the drum after a second that cuts authority [m]."""

CAUTIOUS_TIME = 3.0
"""Time that the share stays cut after the drum was last off [s]."""

PAYOUT = int(WinchLimit.PAYOUT)
"""Limit of the winch at which no model of it holds."""


class TransportReport(NamedTuple):
    """How commands get to the winch.

    Attributes
    ----------
    alarm : what has just become wrong; None: nothing
    inhibition : why compensation must be off; None: it need not
    """

    alarm: Alarm | None = None
    inhibition: Alarm | None = None


class WinchWatch:
    """Compares what the winch did with what it was ordered.

    Parameters
    ----------
    design : with the nominal winch

    Attributes
    ----------
    fault : of the winch, as it reported last: a state that misses its tick takes no fault away
    late_commands : how many commands were late so far, and whether that is more than hiccups
    drum : orders and encoder of the last seconds
    kept : ticks for which the winch has kept its order, as it got none
    """

    def __init__(self, design: ControllerDesign) -> None:
        self.fault = int(WinchFault.NONE)
        self._dt = design.tick_period
        winch = design.parameters.winch
        self.drum = DrumWatch(winch, design.parameters.lag.largest, self._dt)
        self._stated_delay = winch.command_delay
        self.late_commands = LateCommands(design.tick_period)
        self._timeout_cause = TimeoutCause(self._dt)
        self._given: WinchOrder | None = None
        self._cautious = 0.0
        self.kept = 0

    def take(self, assumed: Mapping[str, float]) -> None:
        """Go by the `assumed` winch from now on, by quantity."""
        self.drum.take(assumed)
        self._cautious = 0.0

    @property
    def given(self) -> WinchOrder | None:
        """Order of the last tick; None: none yet."""
        return self._given

    @property
    def share(self) -> float:
        """Largest authority with the winch as it is known."""
        return CAUTIOUS if self._cautious > 0.0 else 1.0

    def fault_cause(self, lateness: Lateness) -> str:
        """Return why the winch has the fault it has, in words, with the `lateness` of the ticks; empty: unknown."""
        return self._timeout_cause.words(lateness) if self.fault == WinchFault.COMMAND_TIMEOUT else ""

    def give(self, order: WinchOrder) -> None:
        """Note the order of a tick."""
        self._given, self.kept = order, 0

    def keep(self) -> None:
        """Note a tick without an order and without a reading: the winch has kept the last order."""
        given, self.kept = self._given, self.kept + 1
        if given is not None and not given.brake:
            self.drum.add(given.payout, given.payout_rate, None)

    def watch(
        self,
        winch: WinchReading | None,
        payout: float | None,
        tension: float,
        parameters: WinchControllerParameters,
    ) -> TransportReport:
        """Put the set-points of the last tick and what the encoder made of them on record; notice late commands.

        Parameters
        ----------
        winch : the winch's own report; None: nothing came
        payout : accepted encoder reading [m]; None: none
        tension : at the top, measured [N]; NaN: not known
        parameters : with the active model of the winch
        """
        given = self._given
        report = TransportReport()
        if winch is not None:
            self.fault = winch.fault
        untaken = 0 if given is None or winch is None else given.sequence - winch.command_sequence
        overdue = untaken * self._dt - parameters.winch.command_delay
        self._timeout_cause.update(has_state=winch is not None, untaken=overdue)
        if given is not None and winch is not None:
            report = self._watch_transport(given.sequence, winch.command_sequence, parameters)
        if given is None or given.brake:
            self.drum.reset(0.0 if given is None else given.payout)
        elif winch is not None and winch.limits_hit & PAYOUT:
            # every other limit, also of torque, pressure and flow, acts as one of speed or acceleration
            self.drum.add(given.payout, given.payout_rate, None, tension=tension)
            self.drum.restart()
        else:
            is_limited = winch is not None and winch.limits_hit != 0
            self.drum.add(given.payout, given.payout_rate, payout, tension=tension, is_limited=is_limited)
            error = abs(self.drum.error())
            self._cautious = CAUTIOUS_TIME if error > ALARMING else max(self._cautious - self._dt, 0.0)
        return report

    def _watch_transport(self, given: int, taken: int, parameters: WinchControllerParameters) -> TransportReport:
        """Notice late commands; nothing is compensated with more delay than can be identified or tolerated."""
        winch = parameters.winch
        # a delay that was learnt to be shorter, what it lacks being taken for lag, makes no command late
        alarm = self.late_commands.update(given, taken, max(winch.command_delay, self._stated_delay))
        if self.late_commands.has_begun:
            self.drum.restart()
        if self.late_commands.is_cut:
            return TransportReport(alarm, ALARMS.alarm("COMMANDS_CUT", time=CUT_TIME))
        lag = winch.command_delay + winch.time_constant
        tolerated = parameters.lag.largest if parameters.identifies_winch else TOLERATED_SHARE * lag
        overdue = self.late_commands.overdue
        if overdue <= tolerated:
            return TransportReport(alarm)
        return TransportReport(alarm, ALARMS.alarm("COMMANDS_TOO_LATE", delay=overdue, limit=tolerated))
