"""What an operator, or the programme in his place, asks of the controller between two ticks."""

from __future__ import annotations

import math

from heave_node.parameters import describe

from winch_controller_node.core.parts import ControllerParts
from winch_controller_node.core.restarts import Event, restart
from winch_controller_node.core.supervision.mode_machine import TRIES
from winch_controller_node.core.supervision.modes import BRAKED, Mode, ModeError
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.interface.requests import DEPTH, FACTOR, HOLD, MODE, Request, stated
from winch_controller_node.motion.operator_speed import OperatorRange
from winch_controller_node.motion.programme import ProgrammeStep
from winch_controller_node.node_parameters import WinchControllerParameters

OPERATED = (Mode.COMPENSATING, Mode.MANUAL)
"""Modes in which an operator may ask for a speed."""

COMING_TO_REST = (Mode.FADE_OUT, Mode.STOPPING)
"""Modes in which no move begins."""

LEAST_MEAN_TIME = 10.0
"""Time over which a tension is averaged at least before it is held as the mean [s]: about a wave."""

LIFTING_SURPLUS = 0.06
"""Tension above the static one that lifts a unit off, in weights of the unit: more than the load cell may err."""


class OperatorRequests(ControllerParts):
    """The requests that a controller takes."""

    def set_mode(self, name: str, tension: float = 0.0, *, consent: bool = False) -> str:
        """Request a mode by name, with the tension to hold [N] in constant_tension (0: the present mean).

        `consent`: compensation may begin although nothing has proved the MRU.

        Returns the mode taken in words. Raises ModeError, saying why, where it cannot be taken.
        """
        self._situation()  # in words, before the request changes what is known of the tick
        restart(self, Event.ASKED)
        self.proofs.ask(consent=consent)
        taken = self._taken(name, tension)
        if name in TRIES:
            restart(self, Event.TRIED)
        return taken

    def _taken(self, name: str, tension: float) -> str:
        """Take a mode as `set_mode` does."""
        if name == Mode.CONSTANT_TENSION.value:
            measured = self._estimation.filtered_tension
            if not math.isfinite(measured):
                raise ModeError("constant tension needs the load cell: no reading received yet")
            if not math.isfinite(tension) or tension < 0.0:
                raise ModeError(f"a tension must be a number of at least 0; got {tension} N")
            was = self.mode
            held = tension if tension > 0.0 else self._present_tension()
            self.modes.request(name)
            self._supervisor.landing.begin_hold()
            self._hold_tension(held, was=was)
            return self.mode.value
        if name == Mode.COMPENSATING.value and self._supervisor.landing.unit_stands:
            self._lift_off()
            return "lifting off: constant tension until the load is suspended"
        self.modes.request(name)
        return self.mode.value

    def ask_for_mode(self, name: str, tension: float = 0.0, *, consent: bool = False) -> str:
        """Request a mode by `name`, with a `tension` and `consent`, as `set_mode` does, but only where it is taken now.

        What was refused does not begin later by itself.

        Returns the mode taken in words, and what follows it. Raises ModeError, saying why, where it cannot be taken.
        """
        request = Request(MODE, (name, stated(tension)) if tension else (name,))
        try:
            words = self._asked_mode(name, stated(tension), consent=consent)
        except ModeError:
            self._requests.append(f"{request.words}: refused")
            raise
        self._requests.append(request.words)
        return words

    def _asked_mode(self, name: str, tension: float, *, consent: bool) -> str:
        """Take a mode as `ask_for_mode` does."""
        self._situation()  # in words, before the request changes what is known of the tick
        self.proofs.ask(consent=consent)
        obstacle = self.proofs.left_of(self.modes.obstacle)
        if name == Mode.COMPENSATING.value and self.mode not in (Mode.OFF, Mode.COMPENSATING) and obstacle:
            raise ModeError(f"mode {name} cannot begin now: {obstacle}")
        taken = self.set_mode(name, tension)
        if self.mode is Mode.OFF or taken not in [mode.value for mode in Mode] or taken == name:
            return taken
        fault = self.modes.fault
        held = f"; the winch reports {fault}: it must be cleared there, or the mode ends again" if fault else ""
        return f"{taken}, on the way to {name}{held}"

    def set_factor(self, factor: float) -> None:
        """Ask for another share of compensation (`factor`, 0 to 1): authority goes there over the fade-in time.

        Raises ParameterError for a share that is not allowed.
        """
        (info,) = (info for info in describe(WinchControllerParameters) if info.name == "factor")
        info.check(factor, where="winch_controller")
        self.modes.set_factor(stated(factor))
        self._requests.append(Request(FACTOR, (factor,)).words)

    def move_to_depth(self, depth: float, speed: float = 0.0) -> None:
        """Move the unit to the mean depth [m] at no more than `speed` [m/s] (0: the default).

        Raises ModeError where the depth is not known, the winch does not compensate, or its range does not reach.
        """
        if self.observer.depth_zero is None:
            raise ModeError("a move needs the depth sensor: no reading received yet")
        if self.mode is not Mode.COMPENSATING:
            raise ModeError(f"a move needs mode compensating; the mode is {self.mode.value}")
        if not math.isfinite(depth):
            raise ModeError(f"a depth must be a number; got {depth} m")
        reference = self.envelope.distance_to(stated(depth) + self.carried)
        self.move_to_payout(self._estimation.payout_at(stated(depth)), stated(speed), reference)
        self._requests.append(Request(DEPTH, (depth, speed) if speed > 0.0 else (depth,)).words)

    def move_to_payout(self, payout: float, speed: float = 0.0, reference: float = math.nan) -> None:
        """Move the mean payout to `payout` [m] at no more than `speed` [m/s] (0: the default).

        `reference` is how far that is by the depth sensor [m], where a depth was requested.

        Raises ModeError where the winch's range does not reach.
        """
        lowest, highest = self._payout_range()
        if not lowest <= payout <= highest:
            raise ModeError(f"that needs a payout of {payout:.1f} m; the winch reaches {lowest:g} to {highest:g} m")
        self.mean.move_to(payout, speed, reference)

    @property
    def is_operated(self) -> bool:
        """Return whether an operator asks for a speed of the mean payout."""
        return self._operator.is_asked

    def operate(self, speed: float) -> None:
        """Lower at a `speed` [m/s], negative lifts, for `operator.timeout`; ends a move that is under way.

        Raises ModeError where the winch neither compensates nor is in mode manual.
        """
        if self.mode not in OPERATED:
            raise ModeError(f"an operator's speed needs mode compensating or manual; the mode is {self.mode.value}")
        if not math.isfinite(speed):
            raise ModeError(f"a speed must be a number; got {speed} m/s")
        self._operator.ask(stated(speed))

    def _follow_operator(self) -> None:
        """Drive the mean payout as the operator asks, and bring it to rest when that has lapsed."""
        if self._operator.is_asked and self.mode in OPERATED:
            self._drive_mean()
        else:
            self._operator.drop()
        self._requests += self._operator.news(self.mean.point.payout)

    def _drive_mean(self) -> None:
        """Drive the mean payout for a tick as the operator asks."""
        bounds = self._operator_range(*self._payout_range(), self.mean.lag)
        limited = self._operator.limit_news(bounds)
        self._alarms += [limited] if limited else []
        self.mean.drive(self._operator.advance(self.mean.point, bounds), bounds.acceleration)

    def _payout_range(self) -> tuple[float, float]:
        """Return the ends of the range that the mean payout may use, less what it is carried along by [m]."""
        lowest, highest = self._command.payout_range()
        return lowest - self.carried, highest - self.carried

    def _operator_range(self, lowest: float, highest: float, lag: float) -> OperatorRange:
        """Return an operator's share of the winch, from a `lowest` to a `highest` payout [m], with a `lag` [s]."""
        limits, shares = self._command.limits, self.parameters.operator
        return OperatorRange(
            speed=shares.speed_share * limits.speed,
            acceleration=shares.acceleration_share * limits.acceleration,
            payout_minimum=lowest,
            payout_maximum=highest,
            lag=lag,
        )

    def carry_mean(self, rate: float, kept: float = 0.0) -> tuple[float, OperatorRange]:
        """Carry the mean payout along in the next tick, beside any move: the place moves about which the tip heaves.

        Depth and depth set-point stay what they are: the unit is where it was.

        Parameters
        ----------
        rate : asked for, positive lowers [m/s]
        kept : room that compensation keeps at the ends of the winch's range [m]

        Returns the rate that is taken [m/s], and the operator's share of the winch within which it is.
        """
        carried, (lowest, highest) = self._estimation.motion.carried, self._command.payout_range()
        kept = min(kept, 0.5 * (highest - lowest))
        bounds = self._operator_range(lowest + kept, highest - kept, carried.lag)
        payout = self.mean.point.payout + carried.point.payout
        taken = bounds.nearest(rate, payout) if self.mode in OPERATED else 0.0
        carried.drive(taken, bounds.acceleration)
        return taken, bounds

    def cancel_move(self) -> None:
        """Bring the mean payout to rest smoothly."""
        if self.mean.has_target:
            self._requests.append(Request(HOLD).words)
        self.mean.stop()

    def skip_programme(self, time: float) -> None:
        """Leave out what the programme had due up to `time` [s]: this controller begins later."""
        self._programme.due(time)

    def _run_programme(self, time: float) -> None:
        """Do what the programme has due; what cannot be done now raises an alarm and is dropped."""
        for due in self._programme.due(time):
            self._do(due)

    def _do(self, due: ProgrammeStep) -> None:
        try:
            if due.mode:
                self.set_mode(due.mode)
            elif self.mode in COMING_TO_REST:
                # the mean payout has just been stopped: a sensor is lost, or compensation does harm
                raise ModeError(
                    f"no move to a payout of {due.payout:.1f} m in mode {self.mode.value}: request it again once the "
                    "winch compensates"
                )
            else:
                before = f", in place of that to {self.mean.target:.1f} m" if self.mean.has_target else ""
                self.move_to_payout(due.payout, due.speed)
                if self.mode in BRAKED:
                    self._alarms.append(
                        ALARMS.alarm(
                            "PROGRAMME_WAITS",
                            time=due.time,
                            payout=due.payout,
                            before=before,
                            mode=self.mode.value,
                        )
                    )
        except (ModeError, ValueError) as error:
            self._alarms.append(ALARMS.alarm("PROGRAMME_REJECTED", time=due.time, cause=str(error)))

    def _present_tension(self) -> float:
        """Return the present mean tension [N].

        At constant tension the winch follows the waves, and what is read is free of them. Raises ModeError where the
        mean is not known yet.
        """
        if self.mode is Mode.CONSTANT_TENSION:
            return self._estimation.filtered_tension
        mean = self._estimation.mean_tension
        wait = LEAST_MEAN_TIME - mean.time
        if wait > 0.0:
            raise ModeError(
                f"averaging the tension for {wait:.0f} s more, with load and mean payout unchanged: request it "
                "again then, or state the tension to hold"
            )
        return mean.value

    def _hold_tension(self, tension: float, *, was: Mode) -> None:
        """Go to a tension [N] from the measured one, or from that held if the mode `was` constant tension already."""
        if was is not Mode.CONSTANT_TENSION:
            self._command.begin_tension(self._estimation.filtered_tension)
        self._command.hold_tension(tension)

    def _lift_off(self) -> None:
        """Raise the tension until the unit hangs."""
        was = self.mode
        self.modes.request(Mode.CONSTANT_TENSION.value)
        self._supervisor.landing.begin_lift_off()
        self._hold_tension(self.design.wet_tension + LIFTING_SURPLUS * self.design.unit_weight, was=was)
