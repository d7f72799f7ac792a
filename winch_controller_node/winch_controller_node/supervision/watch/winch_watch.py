"""Watching the winch: whether it behaves as its model says, and takes commands in time."""

from __future__ import annotations

import math
from concurrent.futures import Executor
from typing import NamedTuple

from heave_node.interface.codes import WinchFault, WinchLimit

from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.design.schedule import is_scheduled
from winch_controller_node.design.work import DesignWork
from winch_controller_node.identification.encoder_scale import Sent
from winch_controller_node.identification.late_commands import CUT_TIME, LateCommands
from winch_controller_node.identification.winch import Answer, WinchIdentifier
from winch_controller_node.interface.readings import Lateness, WinchOrder, WinchReading
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.model import WinchModelParameters
from winch_controller_node.supervision.watch.timeout_cause import TimeoutCause

LEARNING_PERIOD, CHECKING_PERIOD = 2.0, 10.0
"""Time from one identification of the winch to the next [s], while its record grows and when that is full."""

TOLERATED_SHARE = 0.5
"""Further delay with which compensation is tried, over lag and delay of the model, where these are not identified."""

SUSPICIOUS, ALARMING = 0.01, 0.04
"""Errors of the drum after a second [m]: the first has it identified at once, the second cuts the share of the sea."""

CAUTIOUS_SHARE = 0.3
"""Share of the sea that is compensated with a winch that does what nobody understands."""

CAUTIOUS_TIME = 3.0
"""Time that the share stays cut, and the winch is not as believed, after the drum was last off [s]."""

ANSWER_TIME = 0.2
"""What is identified takes effect so long after it was begun [s], also where it is found at once."""

PAYOUT, POWER = int(WinchLimit.PAYOUT), int(WinchLimit.POWER)
"""Limits that the winch may say it has reached."""

URGENT_PERIOD = 0.5
"""Least time between two identifications of a winch that is off [s]."""


def identifies_winch(parameters: WinchControllerParameters) -> bool:
    """Tell whether the winch is identified while the loop runs: a speed servo, no gain schedule in `parameters`."""
    return parameters.lag.adaptation and not is_scheduled(parameters) and parameters.winch.law != "first_order"


class TransportReport(NamedTuple):
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
    designer : identifies beside the ticks, in real time; None: at once

    Attributes
    ----------
    fault : of the winch, as it told last: a state that misses its tick takes no fault away
    late_commands : how many commands were late so far, and whether that is more than hiccups
    """

    def __init__(self, design: ControllerDesign, designer: Executor | None = None) -> None:
        self.fault = int(WinchFault.NONE)
        self._dt = design.tick_period
        self._identifier = WinchIdentifier(design.parameters.lag, design)
        self._stated_delay = design.parameters.winch.command_delay
        self.late_commands = LateCommands(design.tick_period)
        self._work: DesignWork[Answer] = DesignWork(max(1, round(ANSWER_TIME / self._dt)), designer)
        self._timeout_cause = TimeoutCause(self._dt)
        self._given: WinchOrder | None = None
        self._last_state, self._commands_behind, self._ticks_since_state = -math.inf, 0, 0
        self._since_found = 0.0
        self._suspicious = self._cautious = 0.0
        self._power_limited = False

    @property
    def share(self) -> float:
        """Largest share of the sea that may be compensated with what is known of the winch."""
        return CAUTIOUS_SHARE if self._cautious > 0.0 else 1.0

    @property
    def is_as_believed(self) -> bool:
        """Tell whether the drum has done for a while what the model in force predicts."""
        return self._suspicious == 0.0

    def fault_cause(self, lateness: Lateness) -> str:
        """Return why the winch has the fault it has, in words, with the `lateness` of the ticks; empty: unknown."""
        return self._timeout_cause.words(lateness) if self.fault == WinchFault.COMMAND_TIMEOUT else ""

    def give(self, order: WinchOrder) -> None:
        """Note the order of a tick."""
        self._given = order

    def sent(self, time: float, *, as_found: bool = False) -> Sent | None:
        """Return what the encoder reads of what the winch was sent over a `time` [s]; None: unknown.

        The winch is as it was believed to be at first, or `as_found` by now.
        """
        return self._identifier.sent(time, as_found=as_found)

    def forget(self) -> None:
        """Forget what was learnt of the winch: the encoder was wrong."""
        self._work.drop()
        self._identifier.forget()
        self._cautious = 0.0

    def take_back(self, winch: WinchModelParameters) -> None:
        """Forget what the model `winch` does not hold: the encoder has been wrong lately."""
        self._work.drop()
        self._identifier.take_back(winch)

    def improved_winch(
        self, tick: int, winch: WinchModelParameters, *, doubts_encoder: bool = False
    ) -> WinchModelParameters | None:
        """Return the winch as identified; None: the model `winch` in force is as good, or it is not the time.

        Parameters
        ----------
        tick : number of the present one
        winch : in force
        doubts_encoder : what it reads is not believed before it is known to be right
        """
        self._since_found += self._dt
        told = self._identifier.told_winch(winch)
        if told is not None:
            return told
        answer = self._work.take(tick)
        better = None if answer is None or doubts_encoder else self._identifier.take(answer, winch)
        if better is not None:
            self._cautious = 0.0
        elif not self._work.is_under_way:
            self._begin(tick, winch)
        return better

    def _begin(self, tick: int, winch: WinchModelParameters) -> None:
        """Begin to identify the winch beside the ticks, if it is time."""
        period = CHECKING_PERIOD if self._identifier.is_full else LEARNING_PERIOD
        is_off = self._suspicious == CAUTIOUS_TIME
        is_urgent = is_off and self._since_found > URGENT_PERIOD
        if tick % max(1, round(period / self._dt)) != 0 and not is_urgent:
            return
        question = self._identifier.question(winch)
        if question is not None:
            self._since_found = 0.0
            self._work.begin(tick, question)

    @property
    def lone_directions(self) -> dict[str, str]:
        """Return the direction in which alone a limit was found, by the limit's name."""
        return self._identifier.lone_directions

    @property
    def is_power_limited(self) -> bool:
        """Tell whether the winch has said that its power ends."""
        return self._power_limited

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
        self._ticks_since_state += 1
        report = TransportReport()
        if winch is not None:
            self.fault = winch.fault
        untaken = 0 if given is None or winch is None else given.sequence - winch.command_sequence
        overdue = untaken * self._dt - parameters.winch.command_delay
        self._timeout_cause.update(has_state=winch is not None, untaken=overdue)
        if given is not None and winch is not None:
            report = self._watch_transport(given.sequence, winch.command_sequence, parameters)
        if given is None or given.brake:
            self._work.drop()
            self._identifier.reset(0.0 if given is None else given.payout)
        elif winch is not None and (self._is_irregular(given, winch) or winch.limits_hit & PAYOUT):
            # every other limit, also of torque, pressure and flow, acts as one of speed or acceleration
            self._identifier.add(given.payout, given.payout_rate, None)
            self._identifier.restart()
        else:
            limits_hit = WinchLimit.NONE if winch is None else winch.limits_hit
            self._identifier.add(given.payout, given.payout_rate, payout, limits_hit)
            self._check_drum(parameters.winch)
        if winch is not None and winch.limits_hit & POWER:
            self._power_limited = True
        return report

    def _is_irregular(self, given: WinchOrder, winch: WinchReading) -> bool:
        """Tell whether a command or a state was late: what the drum did then is not what it was sent a delay before.

        A machine that stalls for a moment must not be taken for a winch that is weak. A transport that is slower for
        good is regular.
        """
        behind, passed = given.sequence - winch.command_sequence, winch.time - self._last_state
        is_irregular = behind != self._commands_behind or abs(passed - self._ticks_since_state * self._dt) > (
            0.5 * self._dt
        )
        self._commands_behind, self._last_state, self._ticks_since_state = behind, winch.time, 0
        return is_irregular

    def _check_drum(self, winch: WinchModelParameters) -> None:
        """Compare the drum with its prediction over the last second."""
        error = abs(self._identifier.error(winch))
        self._suspicious = CAUTIOUS_TIME if error > SUSPICIOUS else max(self._suspicious - self._dt, 0.0)
        self._cautious = CAUTIOUS_TIME if error > ALARMING else max(self._cautious - self._dt, 0.0)

    def _watch_transport(self, given: int, taken: int, parameters: WinchControllerParameters) -> TransportReport:
        """Notice late commands; nothing is compensated with more delay than can be identified or tolerated."""
        winch = parameters.winch
        # a delay that was learnt to be shorter, what it lacks being taken for lag, makes no command late
        alarm = self.late_commands.update(given, taken, max(winch.command_delay, self._stated_delay))
        if self.late_commands.has_begun:
            self._identifier.restart()
        if self.late_commands.is_cut:
            return TransportReport(alarm, f"no command reached the winch for {CUT_TIME:g} s")
        lag = winch.command_delay + winch.time_constant
        tolerated = parameters.lag.largest if identifies_winch(parameters) else TOLERATED_SHARE * lag
        overdue = self.late_commands.overdue
        if overdue <= tolerated:
            return TransportReport(alarm)
        return TransportReport(
            alarm, f"winch commands take effect {overdue:.2f} s later than modelled: too late for a stable loop"
        )
