"""Watching the winch: whether it is the one believed in, and takes commands in time."""

from __future__ import annotations

from heave_node.codes import WinchLimit

from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.design.schedule import is_scheduled
from winch_controller_node.identification.winch import LateCommands, WinchIdentifier
from winch_controller_node.interface.readings import WinchOrder, WinchReading
from winch_controller_node.parameters.controller import WinchControllerParameters
from winch_controller_node.supervision.guard import HarmGuard

LEARNING_PERIOD, CHECKING_PERIOD = 2.0, 10.0
"""Time from one look at the record of the winch to the next [s], while it grows and when it is full."""

BEARABLE_SHARE = 0.5
"""Further delay that is tried, over lag and delay believed in, where they are not learnt."""

UNLEARNT_LIMITS = WinchLimit.PAYOUT | WinchLimit.POWER
"""Limits of a winch that its identification does not know."""


def learns_winch(parameters: WinchControllerParameters) -> bool:
    """Tell whether a winch other than believed is learnt: a speed servo's, without a schedule."""
    return parameters.lag.adaptation and not is_scheduled(parameters) and parameters.winch.law != "first_order"


class WinchWatch:
    """Compares what the winch was sent with what it made of it.

    Parameters
    ----------
    design : the winch believed in at the start
    guard : keeps compensation off where commands come too late
    """

    def __init__(self, design: ControllerDesign, guard: HarmGuard) -> None:
        self._dt = design.tick_period
        self._guard = guard
        self._identifier = WinchIdentifier(design.parameters.lag, design)
        self._late_commands = LateCommands(design.tick_period)
        self._given: WinchOrder | None = None

    def give(self, order: WinchOrder) -> None:
        """Note the order of a tick."""
        self._given = order

    def better_belief(self, tick: int, parameters: WinchControllerParameters) -> WinchControllerParameters | None:
        """Return parameters of the winch that was found, at the ticks at which one looks; None: keep the present."""
        period = CHECKING_PERIOD if self._identifier.is_full else LEARNING_PERIOD
        if tick % max(1, round(period / self._dt)) != 0:
            return None
        return self._identifier.better_belief(parameters)

    def watch(
        self, winch: WinchReading | None, payout: float | None, parameters: WinchControllerParameters
    ) -> list[str]:
        """Put the set-points of the last tick and what the encoder made of them on record; notice late commands.

        Parameters
        ----------
        winch : what the winch says of itself; None: nothing came
        payout : accepted encoder reading [m]; None: none
        parameters : the winch believed in now

        Returns what is wrong with the transport, in words.
        """
        given = self._given
        alarms = []
        if given is not None and winch is not None:
            alarms = self._watch_transport(given.sequence, winch.command_sequence, parameters)
        if given is None or given.brake:
            self._identifier.reset(0.0 if given is None else given.payout)
        elif winch is not None and winch.limits_hit & UNLEARNT_LIMITS:
            self._identifier.add(given.payout, given.payout_rate, None)
            self._identifier.restart()
        else:
            self._identifier.add(given.payout, given.payout_rate, payout)
        return alarms

    def _watch_transport(self, given: int, taken: int, parameters: WinchControllerParameters) -> list[str]:
        """Notice late commands; no feedback of the unit is tried with more delay than can be learnt or borne."""
        winch = parameters.winch
        words = self._late_commands.update(given, taken, winch.command_delay)
        if words:
            self._identifier.restart()
        lag = winch.command_delay + winch.time_constant
        bearable = parameters.lag.largest if learns_winch(parameters) else BEARABLE_SHARE * lag
        overdue = self._late_commands.overdue
        if overdue > bearable:
            self._guard.hold_off(f"winch takes commands {overdue:.2f} s later than believed: no loop bears that")
        return [words] if words else []
