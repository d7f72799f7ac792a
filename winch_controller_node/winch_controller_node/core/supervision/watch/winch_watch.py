"""Watching the winch: whether it does what is predicted of it, and takes commands in time."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from heave_core.law import put
from heave_core.watch import WinchRecord
from heave_node.interface.alarm import Alarm
from heave_node.interface.codes import WinchFault, WinchLimit

from winch_controller_node.beliefs.drum import drum_of
from winch_controller_node.core.supervision.late_commands import (
    CUT_TIME,
    ROUNDING,
    LateCommands,
    TimeoutCause,
    link_values,
)
from winch_controller_node.core.supervision.watch.drum_watch import DrumWatch, watched
from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.interface.readings import Lateness, WinchOrder, WinchReading
from winch_controller_node.node_parameters import WinchControllerParameters

TOLERATED_SHARE = 0.5
"""Further delay with which compensation is tried, over lag and delay of the model, where these are not identified."""

PAYOUT = int(WinchLimit.PAYOUT)
"""Limit of the winch at which no model of it holds."""


class TransportReport(NamedTuple):
    """How commands get to the winch."""

    alarm: Alarm | None = None  # what has just become wrong; None: nothing
    inhibition: Alarm | None = None  # why compensation must be off; None: it need not


ON_TIME = TransportReport()
"""Commands that get there in time."""

NO_ORDER, NO_REPORT = (math.nan, 0.0, 0.0, False), (False, 0, 0, False)
"""Rows of WINCH_SEEN for a tick before the first order, and for one in which the winch has not reported."""


class WinchWatch:
    """Compares what the winch did with what it was ordered.

    `design` : with the nominal winch
    """

    def __init__(self, design: ControllerDesign) -> None:
        # of the winch, as it reported last: a state that misses its tick takes no fault away
        self.fault = int(WinchFault.NONE)
        winch, largest, dt = design.parameters.winch, design.parameters.lag.largest, design.tick_period
        self._core = WinchRecord(
            {
                "drum": watched(drum_of(winch), largest, winch.position_gain, dt),
                "link": link_values(dt),
                "delay": winch.command_delay,
                "modelled": winch.command_delay,
            }
        )
        self.drum = DrumWatch(winch, largest, dt, self._core.drum)  # orders and encoder of the last seconds
        self._stated_delay, self._parameters = winch.command_delay, design.parameters
        # how many commands were late so far, and whether that is more than hiccups
        self.late_commands = LateCommands(dt, self._core.link)
        self._timeout_cause = TimeoutCause(dt, self._core.link)
        self._link, self._error = self._core.link.state[0], self._core.state["error"]
        self._given: WinchOrder | None = None
        self.kept = 0  # ticks for which the winch has kept its order, as it got none

    def take(self, assumed: Mapping[str, float]) -> None:
        """Go by the `assumed` winch from now on, by quantity."""
        self.drum.take(assumed)

    @property
    def given(self) -> WinchOrder | None:
        """Order of the last tick; None: none yet."""
        return self._given

    @property
    def drum_error(self) -> float:
        """Payout of the drum less what was predicted of it a second ago [m]; 0 where unknown."""
        return float(self._error[0])

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
        if parameters is not self._parameters:
            self._parameters, delay = parameters, parameters.winch.command_delay
            # a delay that was learnt to be shorter, what it lacks being taken for lag, makes no command late
            put(self._core.design, {"delay": delay, "modelled": max(delay, self._stated_delay)})
        given, reading = self._given, math.nan if payout is None else payout
        order = NO_ORDER if given is None else (given.sequence, given.payout, given.payout_rate, given.brake)
        reports = NO_REPORT
        if winch is not None:
            self.fault, limits = winch.fault, winch.limits_hit
            # every limit but that of the payout, also of torque and pressure, acts as one of speed or acceleration
            reports = (True, winch.command_sequence, limits & PAYOUT, limits != 0)
        self._core.watch(*reports, *order, reading, tension)
        return self._transport(parameters)

    def _transport(self, parameters: WinchControllerParameters) -> TransportReport:
        """Return late commands; nothing is compensated with more delay than can be identified or tolerated."""
        late, link = self.late_commands, self._link
        if not (link["news"] or link["is_cut"] or link["overdue"]):
            return ON_TIME
        if late.is_cut:
            return TransportReport(late.news, ALARMS.alarm("COMMANDS_CUT", time=CUT_TIME))
        limit = tolerated_delay(parameters)
        if late.overdue <= limit:
            return TransportReport(late.news)
        return TransportReport(late.news, ALARMS.alarm("COMMANDS_TOO_LATE", delay=late.overdue, limit=limit))


def tolerated_delay(parameters: WinchControllerParameters) -> float:
    """Return the further delay of commands with which compensation is tried by `parameters`, with rounding [s]."""
    winch = parameters.winch
    of_model = TOLERATED_SHARE * (winch.command_delay + winch.time_constant)
    return (parameters.lag.largest if parameters.identifies_winch else of_model) * (1.0 + ROUNDING)
