"""The active beliefs, and the one way in which another answer of the adviser becomes active."""

from __future__ import annotations

import math

from heave_node.interface.alarm import Alarm

from winch_controller_node.beliefs.beliefs import (
    Adopted,
    Beliefs,
    EncoderScale,
    Finding,
    corrections,
    latency_ticks,
    parameters_under,
    without_sea,
)
from winch_controller_node.beliefs.quantities import ENCODER_SCALE, QUANTITIES, out_of_range, restated
from winch_controller_node.beliefs.words import alarms_of
from winch_controller_node.core.design_in_force import DesignInForce, designed
from winch_controller_node.core.estimation.loop_estimation import LoopEstimation
from winch_controller_node.core.supervision.watch.winch_watch import WinchWatch
from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.node_parameters import WinchControllerParameters

FIRST_TIME, GROWTH, MOST = 60.0, 4.0, 3
"""Time for which no answer is used at first [s], factor by which it grows, and count after which none is used again."""


class AdviserTrust:
    """Whether the adviser's answers are used: not for a time where they cannot be, or the readings contradict them.

    Each time is longer than the one before, and a count ends it. `tick_period` : [s]
    """

    def __init__(self, tick_period: float) -> None:
        self._dt = tick_period
        self._until = 0.0
        self.count = 0  # times that it was wrong
        self._news: list[Alarm] = []

    def accepts(self, tick: int) -> bool:
        """Tell whether answers are used at a `tick`."""
        return tick * self._dt >= self._until

    def contradict(self, fault: str, tick: int) -> None:
        """Use no answer for a time from a `tick` on, for a `fault` in words."""
        time = FIRST_TIME * GROWTH**self.count
        self.count += 1
        if self.count < MOST:
            self._until = tick * self._dt + time
            self._news.append(ALARMS.alarm("ADVISER_WRONG: set aside", fault=fault, time=time))
        else:
            self._until = math.inf
            self._news.append(ALARMS.alarm("ADVISER_WRONG: excluded", fault=fault, count=self.count))

    def restart(self) -> None:
        """Use answers again: an operator has restated what is nominal."""
        self._until, self.count = 0.0, 0

    def news(self) -> list[Alarm]:
        """Return, once, what is new."""
        found, self._news = self._news, []
        return found


NONE = Beliefs(asked=-1)
"""All is nominal."""

DROPPED = -1
"""Number of the active beliefs where the core has dropped those of the adviser, which restarts."""

CONTRADICTED = 12.0
"""Evidence for nominal values against the active beliefs at which these are dropped [nats]."""

OWN = "encoder"
"""Sensor that a reflex of the core alone sets aside and uses again: what the adviser says of that is an echo."""


class BeliefsInForce:
    """Nominal parameters and the active beliefs: their only home in the core.

    `in_force`, `estimation`, `winch` : what goes by the beliefs
    """

    def __init__(self, in_force: DesignInForce, estimation: LoopEstimation, winch: WinchWatch) -> None:
        self._in_force, self._estimation, self._winch = in_force, estimation, winch
        self._latency = latency_ticks(in_force.design.tick_period)
        self._first = in_force.parameters
        self.nominal: WinchControllerParameters = self._first  # parameters as an operator has stated them
        # those that have changed since the start, and what to, by path
        self.restated: tuple[tuple[str, float], ...] = ()
        self.beliefs = NONE  # the active ones
        self._pending: Beliefs | None = None
        self._followed = -1  # tick before which what was due was activated last
        self.refused = 0  # answers that came too late, so far
        self._unsaid: tuple[Finding, ...] = ()  # what they found: later answers have its value, not the finding
        self.trust = AdviserTrust(in_force.design.tick_period)  # whether the answers of the adviser are used
        self._plain: ControllerDesign | None = self._in_force.design
        # owners whose assumed values have changed in this tick: winch, cable, a sensor
        self.corrected: set[str] = set()
        # the boom tip is taken to be elsewhere since this tick: what was seen of the sea is void
        self.has_moved_tip = False

    def offer(self, beliefs: Beliefs, next_tick: int) -> bool:
        """Take `beliefs`, active LATENCY after they were asked for; return whether in time for `next_tick`."""
        if beliefs.asked + self._latency < next_tick:
            self.refused += 1
            self._unsaid += beliefs.findings if self.trust.accepts(next_tick) else ()
            return False
        if not self.trust.accepts(next_tick):
            return True
        fault = impossible(beliefs, self.nominal)
        if fault:
            self._drop(fault, next_tick)
        else:
            self._pending = beliefs
        return True

    def _hold_against_nominal(self, tick: int) -> None:
        """Drop the beliefs where nominal values explain the readings up to a `tick` clearly better."""
        second = self._estimation.second
        if second is None or second.nats < CONTRADICTED:
            return
        row, ratio = second.witness
        self.contradict(f"with nominal values {row} is {ratio:.1f} times nearer to its prediction", tick)

    def contradict(self, why: str, tick: int) -> None:
        """Drop the beliefs from a `tick` on, for a reason `why` in words: the readings contradict them."""
        second, held = self._estimation.second, without_sea(self.beliefs).values
        found = ", ".join(f"{name} {belief.value:.3g}" for name, belief in held.items() if belief.nats != 0.0)
        self._drop(f"{found}; {why}", tick, None if second is None else second.state(tick - 1))

    def _drop(self, fault: str, next_tick: int, adopted: Adopted | None = None) -> None:
        """Go on with all nominal from the `next_tick`, at a state to be `adopted`, for a `fault` in words."""
        self.trust.contradict(fault, next_tick)
        self._pending, self._unsaid = None, ()
        if self.beliefs.number > 0 or self.beliefs.values:
            encoder = None if self.beliefs.encoder is None else EncoderScale(next_tick)
            plain = self._plain_design()
            design = None if self._in_force.design is plain else plain
            self._pending = Beliefs(next_tick - self._latency, DROPPED, encoder=encoder, design=design, adopted=adopted)

    def follow(self, tick: int) -> list[Alarm]:
        """Activate before a `tick` what is due; return what is new, once."""
        self.corrected, self.has_moved_tip = set(), False
        if tick != self._followed:
            self._hold_against_nominal(tick)
        self._followed = tick
        pending, news = self._pending, self.trust.news()
        if pending is None or pending.asked + self._latency > tick:
            return news
        found, self._pending, self._unsaid = self._unsaid, None, ()
        was = self.beliefs.excluded
        if pending.number != self.beliefs.number:
            self._take(pending, tick)
        return [*news, *alarms_of((*found, *_findings_of(pending, was)))]

    def _run_second(self, tick: int) -> None:
        """Run a filter with nominal values beside the active one from a `tick` on, while that has others."""
        if not without_sea(self.beliefs).values:
            self._estimation.drop_second()
        elif self._estimation.second is None and self._plain is not None:
            self._estimation.begin_second(self._plain, tick - 1)

    def renew(self, nominal: WinchControllerParameters) -> None:
        """Go by other `nominal` parameters; beliefs about the sea are void."""
        self.nominal, self._pending, self._unsaid = nominal, None, ()
        self.restated = restated(self._first, nominal)
        self.beliefs = without_sea(self.beliefs)
        self.trust.restart()
        # its nominal values are those of before
        self._estimation.drop_second()
        self._plain = None if self.beliefs.values else self._in_force.design

    def _note_plain(self) -> None:
        """Note the active design where it is the nominal one, until another length of cable is out."""
        if not self.beliefs.values:
            self._plain = self._in_force.design
        elif self._plain is not None and self._plain.length != self._in_force.design.length:
            self._plain = None
            self._estimation.drop_second()

    def _plain_design(self) -> ControllerDesign:
        """Return the nominal design, made now where no tick has had it yet."""
        payout = self._estimation.motion.mean.point.payout
        return self._plain or designed(self.nominal, payout, self._in_force.design.tick_period)

    def under(self, nominal: WinchControllerParameters) -> WinchControllerParameters:
        """Return the parameters under the active beliefs, were others `nominal`; beliefs about the sea are void."""
        return parameters_under(without_sea(self.beliefs), nominal)

    def _take(self, beliefs: Beliefs, tick: int) -> None:
        """Jump: all that goes by beliefs goes by these from now on.

        | what has changed | estimate | what is restarted |
        |---|---|---|
        | limits, gain of the winch | stays | drum watch |
        | lag, delay, sea | carried over | drum watch (winch) |
        | sensor, cable | the adviser's, followed up to now | consistency, guard's comparison |
        | MRU | the same | besides: what was seen of the sea |
        """
        before, self.beliefs = self.beliefs, beliefs
        self._run_second(tick)
        parameters = parameters_under(beliefs, self.nominal)
        changed = {
            QUANTITIES[name].owner
            for name in {*before.values, *beliefs.values}
            if before.values.get(name) != beliefs.values.get(name)
        }
        estimation, observer = self._estimation, self._estimation.observer
        observer.correct(corrections(beliefs, self.nominal))
        excluded, was = (one.excluded if one.excluded != OWN else "" for one in (beliefs, before))
        if excluded != was:
            observer.exclude(excluded)
            changed |= {excluded, was} - {""}
        if beliefs.encoder is not None and beliefs.encoder != before.encoder:
            observer.exclude(excluded)
            estimation.rescale_encoder(beliefs.encoder, tick - 1, is_adopted=beliefs.adopted is not None)
        carried = None
        if beliefs.design is not None:
            carried = self._in_force.take_design(parameters, beliefs.design)
        self._in_force.take_limits(parameters.winch)
        self._note_plain()
        if beliefs.design is None:
            estimation.take_limits(self._in_force.design)
        if beliefs.adopted is not None:
            estimation.adopt(self._in_force.design, None if carried is None else carried[0], beliefs.adopted, tick - 1)
        elif carried is not None:
            estimation.carry(self._in_force.design, *carried)
        if "winch" in changed:
            self._winch.take({name: belief.value for name, belief in beliefs.values.items()})
        if "mru" in changed:
            self.has_moved_tip = True
            estimation.reset_sea()
        self.corrected = changed - {"sea"}


def _findings_of(beliefs: Beliefs, was: str) -> tuple[Finding, ...]:
    """Return what is new in `beliefs` where a sensor `was` excluded: an exclusion is said, whether reported or not."""
    is_said = beliefs.excluded in ("", OWN, was) or any(one.code == "excluded" for one in beliefs.findings)
    return beliefs.findings if is_said else (*beliefs.findings, Finding("excluded", beliefs.excluded))


def impossible(beliefs: Beliefs, nominal: WinchControllerParameters) -> str:
    """Return what of `beliefs` cannot be with `nominal` parameters, in words; empty: all can."""
    values = {name: belief.value for name, belief in beliefs.values.items()}
    scale = 1.0 if beliefs.encoder is None else beliefs.encoder.scale
    return out_of_range(values, nominal) or out_of_range({ENCODER_SCALE: scale}, nominal)
