"""Watching the winch: whether it does what is predicted of it, and takes commands in time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from heave_core.law import put
from heave_core.watch import WinchRecord
from heave_node.interface.alarm import Alarm
from heave_node.interface.codes import WinchFault

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
from winch_controller_node.interface.readings import Measurements, WinchOrder
from winch_controller_node.node_parameters import WinchControllerParameters

TOLERATED_SHARE = 0.5
"""Further delay with which compensation is tried, over lag and delay of the model, where these are not identified."""


class TransportReport(NamedTuple):
    """How commands get to the winch."""

    alarm: Alarm | None = None  # what has just become wrong; None: nothing
    inhibition: Alarm | None = None  # why compensation must be off; None: it need not


ON_TIME = TransportReport()
"""Commands that get there in time."""


class WinchWatch:
    """Compares what the winch did with what it was ordered.

    `design` : with the nominal winch
    """

    def __init__(self, design: ControllerDesign) -> None:
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
        self._stated_delay = winch.command_delay
        # how many commands were late so far, and whether that is more than hiccups
        self.late_commands = LateCommands(dt, self._core.link)
        self._timeout_cause = TimeoutCause(dt, self._core.link)
        self._link, self._error = self._core.link.state[0], self._core.state["error"]
        self.records = self._core.records
        self.kept = 0  # ticks for which the winch has kept its order, as it got none
        self.refer_to(design.parameters)

    def take(self, assumed: Mapping[str, float]) -> None:
        """Go by the `assumed` winch from now on, by quantity."""
        self.drum.take(assumed)

    @property
    def drum_error(self) -> float:
        """Payout of the drum less what was predicted of it a second ago [m]; 0 where unknown."""
        return float(self._error[0])

    def fault_cause(self, fault: int, seen: Measurements) -> str:
        """Return why the winch has a `fault`, in words, by what was `seen` in the tick; empty: unknown."""
        if fault == WinchFault.COMMAND_TIMEOUT:
            return self._timeout_cause.words(seen.lateness)
        return "" if not fault or seen.winch is None or seen.winch.fault else "it was restarted"

    def take_kept(self) -> int:
        """Return for how many ticks the winch has kept its order until now, once."""
        kept, self.kept = self.kept, 0
        return kept

    def keep(self, given: WinchOrder | None) -> None:
        """Note a tick without an order and without a reading: the winch has kept the last one `given`; None: none."""
        self.kept += 1
        if given is not None and not given.brake:
            self.drum.add(given.payout, given.payout_rate, None)

    def refer_to(self, parameters: WinchControllerParameters) -> None:
        """Go by the delay of the winch that is assumed from now on, by the active `parameters`."""
        delay = parameters.winch.command_delay
        # a delay that was learnt to be shorter, what it lacks being taken for lag, makes no command late
        put(self._core.design, {"delay": delay, "modelled": max(delay, self._stated_delay)})
        self.tolerated_delay = tolerated_delay(parameters)

    def transport(self) -> TransportReport:
        """Return late commands; nothing is compensated with more delay than can be identified or tolerated."""
        late, link = self.late_commands, self._link
        if not (link["news"] or link["is_cut"] or link["overdue"]):
            return ON_TIME
        if late.is_cut:
            return TransportReport(late.news, ALARMS.alarm("COMMANDS_CUT", time=CUT_TIME))
        limit = self.tolerated_delay
        if late.overdue <= limit:
            return TransportReport(late.news)
        return TransportReport(late.news, ALARMS.alarm("COMMANDS_TOO_LATE", delay=late.overdue, limit=limit))


def tolerated_delay(parameters: WinchControllerParameters) -> float:
    """Return the further delay of commands with which compensation is tried by `parameters`, with rounding [s]."""
    winch = parameters.winch
    of_model = TOLERATED_SHARE * (winch.command_delay + winch.time_constant)
    return (parameters.lag.largest if parameters.identifies_winch else of_model) * (1.0 + ROUNDING)
