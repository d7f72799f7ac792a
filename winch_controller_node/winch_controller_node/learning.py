"""Learning in a running loop: what winch, sea and sensors really are; each change is made and told once.

Limits and gain of the winch are used at once. All else needs another design, which is made beside the ticks.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

from winch_controller_node.design.schedule import is_scheduled
from winch_controller_node.design.work import DesignWork
from winch_controller_node.design_in_force import DesignInForce, PreparedDesign
from winch_controller_node.encoder_learning import EncoderLearning
from winch_controller_node.estimation.loop_estimation import LoopEstimation
from winch_controller_node.estimation.reading_record import RECORD
from winch_controller_node.identification.likeliest_sea import likeliest_sea
from winch_controller_node.identification.suspicion_times import LONGER, SHORT_RECORD, SURPRISED_TIME, SuspicionTimes
from winch_controller_node.identification.suspicions import CABLE, Suspicion, Verdict, continued, suspect
from winch_controller_node.identification.winch import gains_otherwise, is_weaker, lags_otherwise
from winch_controller_node.interface.sensors import MRU_BIAS
from winch_controller_node.model.estimator import RecordedTick
from winch_controller_node.model.lqr import DesignError
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.model import SeaModelParameters
from winch_controller_node.supervision.watch.winch_news import WinchNews
from winch_controller_node.supervision.watch.winch_watch import WinchWatch, identifies_winch

DESIGN_TIME = 1.0
"""A design that the loop asks for takes effect so long after it was begun [s], also where it is made at once."""

FIRST_SEAS_PATIENCE, LONGEST_SEAS_PATIENCE = 5.0, 120.0
"""Time from one comparison of seas to the next [s]; it grows by LONGER while no other sea is found."""

LOST_TIME = 1.0
"""An encoder that is lost for so long is lost indeed [s]; one with play is still for a moment when the drum turns."""


@dataclass(frozen=True)
class Learnt:
    """A design for something that was learnt.

    Attributes
    ----------
    prepared : the design
    verdict : on sensors and cable; None: it was learnt of winch or sea
    """

    prepared: PreparedDesign
    verdict: Verdict | None = None


class Learning:
    """Learns while the loop runs.

    Parameters
    ----------
    in_force, estimation, winch : what goes on with what is learnt
    designer : makes designs beside the ticks, in real time; None: at once

    Attributes
    ----------
    corrected : what was believed, until this tick, in a way under which the loop could not work: winch, cable, a sensor
    has_moved_tip : the boom tip was not, until this tick, where it was taken to be: what was seen of the sea is void
    """

    def __init__(
        self, in_force: DesignInForce, estimation: LoopEstimation, winch: WinchWatch, designer: Executor | None
    ) -> None:
        self._in_force = in_force
        self._estimation = estimation
        self._winch = winch
        self._dt = in_force.design.tick_period
        self._work: DesignWork[Learnt | None] = DesignWork(max(1, round(DESIGN_TIME / self._dt)), designer)
        self._encoder = EncoderLearning(in_force, estimation, winch)
        self._news = WinchNews(in_force.parameters.winch, tick_period=self._dt)
        self._times = SuspicionTimes(self._dt)
        self._lost_ticks = 0
        self._first_sea = in_force.parameters.sea
        self._seas_compared, self._seas_patience = -math.inf, FIRST_SEAS_PATIENCE
        self._refused = ""
        self.corrected: set[str] = set()
        self.has_moved_tip = False

    @property
    def inhibition(self) -> str:
        """Why compensation must be off; empty: it need not."""
        return self._encoder.inhibition

    @property
    def is_contrary(self) -> bool:
        """Tell whether drum or encoder go the other way than the winch is sent."""
        return self._encoder.is_contrary

    def drop(self) -> None:
        """Forget the design that is under way: another one is in force."""
        self._work.drop()

    def follow(self, tick: int, *, moves: bool, compensates: bool, is_trusted: bool) -> list[str]:
        """Do what there is to learn before `tick`; return what has been learnt, in words.

        Parameters
        ----------
        tick : that comes
        moves : the winch does, or is to: the encoder is compared with it then
        compensates : the loop does: the winch is learnt then only
        is_trusted : the guard trusts the estimate; where it does not, sensors are suspected at once
        """
        self.corrected.clear()
        self.has_moved_tip = False
        self._times.pass_tick(tick, self._estimation.surprise, is_doubted=bool(self._estimation.observer.doubted))
        words = self._take(tick)
        parameters = self._in_force.parameters
        is_learning = compensates and identifies_winch(parameters)
        has_schedule = is_scheduled(parameters)
        if identifies_winch(parameters):
            self._watch_encoder(tick)
        if moves and identifies_winch(parameters):
            words += self._compare_encoder(tick)
        if is_learning:
            self._follow_winch(tick)
        words += self._news.update(
            self._in_force.parameters.winch,
            directions=lambda: self._winch.lone_directions,
            is_power_limited=self._winch.is_power_limited,
            is_learning=is_learning or self._encoder.doubts_encoder,
            is_rescaled=self._estimation.observer.encoder.scale != 1.0,
        )
        if not has_schedule and not self._work.is_under_way:
            self._follow_sea(tick)
        if not has_schedule and not self._work.is_under_way and not self._encoder.doubts_encoder:
            self._suspect_sensors(tick, is_trusted=is_trusted)
        return words

    def _take(self, tick: int) -> list[str]:
        """Go on with a design once it is ready."""
        try:
            learnt = self._work.take(tick)
        except DesignError as error:
            refused = f"what was learnt is not used: {error}"
            is_known, self._refused = refused == self._refused, refused
            return [] if is_known else [refused]
        if learnt is None:
            return []
        if learnt.verdict is not None:
            return self._take_verdict(tick, learnt.prepared, learnt.verdict)
        before = self._in_force.parameters
        matrix, added = self._in_force.take_learnt(learnt.prepared)
        self._estimation.carry(self._in_force.design, matrix, added)
        after = self._in_force.parameters
        if after.sea == before.sea:
            return []
        self._seas_patience = FIRST_SEAS_PATIENCE
        changes = _changes(before.sea, after.sea)
        return [f"sea model updated: {changes}"] if changes else []

    # scales of encoder and motion reference unit

    def _compare_encoder(self, tick: int) -> list[str]:
        """Use another scale of the encoder, or do without the motion reference unit, where that has been found."""
        words = self._encoder.follow(tick)
        if self._encoder.has_found:
            self._work.drop()  # it was begun with what was wrong
            self.corrected.add("encoder")
        return words

    def _watch_encoder(self, tick: int) -> None:
        """Take back what was learnt of the winch, and not told yet, once the encoder is frozen: that taught it.

        It takes some seconds to tell a frozen encoder from a drum that turns slowly. Once an encoder is back after it
        was lost, the drum is where that has it.
        """
        gate, lasting = self._estimation.observer.gates["encoder"], round(LOST_TIME / self._dt)
        before, self._lost_ticks = self._lost_ticks, self._lost_ticks + 1 if gate.is_lost else 0
        if before >= lasting and not gate.is_lost:
            self._estimation.find_drum(tick - 1)
        if self._lost_ticks != lasting or gate.reason != "frozen":
            return
        told, parameters = self._news.told, self._in_force.parameters
        self._winch.take_back(told)
        self._in_force.take_limits(told)
        winch = parameters.winch
        if (told.time_constant, told.command_delay) != (winch.time_constant, winch.command_delay):
            self._work.drop()
            self._design_for(tick, replace(parameters, winch=told))

    def trust_encoder(self) -> None:
        """Try an encoder again that was set aside: an operator asks for it."""
        self._encoder.trust_encoder()

    # the winch

    def _follow_winch(self, tick: int) -> None:
        """Use limits and gain as found at once; begin to design for another servo or delay."""
        before = self._in_force.parameters.winch
        found = self._winch.improved_winch(tick, before, doubts_encoder=self._encoder.doubts_encoder)
        if found is None:
            return
        self._in_force.take_limits(found)
        if any(differs(found, before) for differs in (is_weaker, lags_otherwise, gains_otherwise)):
            self.corrected.add("winch")
        if (found.time_constant, found.command_delay) != (before.time_constant, before.command_delay):
            self._design_for(tick, replace(self._in_force.parameters, winch=found))

    # the sea

    def _follow_sea(self, tick: int) -> None:
        """Begin to design for the sea that is seen, where that is another one and foresees the readings better."""
        seas = self._estimation.possible_seas()
        now = tick * self._dt
        if seas is None or now - self._seas_compared < self._seas_patience:
            return
        self._seas_compared = now
        self._seas_patience = min(LONGER * self._seas_patience, LONGEST_SEAS_PATIENCE)
        in_force, record = self._in_force, self._estimation.sea_record.ticks()
        parameters = in_force.parameters

        def judged() -> Learnt | None:
            sea = likeliest_sea(parameters, seas, record, in_force.design_for, self._dt)
            return None if sea is None else Learnt(in_force.prepared_for(replace(parameters, sea=sea)))

        self._work.begin(tick, judged)

    def _design_for(self, tick: int, parameters: WinchControllerParameters) -> None:
        """Begin to design for another winch or sea, unless a design is under way: what is learnt comes again."""
        if not self._work.is_under_way:
            in_force = self._in_force
            self._work.begin(tick, lambda: Learnt(in_force.prepared_for(parameters)))

    # the sensors

    def _suspect_sensors(self, tick: int, *, is_trusted: bool) -> None:
        """Begin to look for the sensor at fault where the estimate is not trusted, or has foreseen badly for long."""
        estimation, times = self._estimation, self._times
        in_force, doubted = self._in_force, estimation.observer.doubted
        is_due = estimation.record.covers(RECORD if is_trusted else SHORT_RECORD) and times.is_due(
            tick,
            estimation.surprise,
            is_doubted=bool(doubted),
            is_trusted=is_trusted,
            knows_winch=self._winch.is_as_believed,
        )
        if not is_due:
            return
        records, is_mixed = self._records()
        is_early, scale, first_sea = times.is_early, estimation.mru_scale, self._first_sea

        def judged() -> Learnt | None:
            believed, design_for = in_force.parameters, in_force.design_for
            verdicts: list[Verdict] = []
            for record in records:
                verdicts.append(
                    suspect(believed, record, design_for, self._dt, doubted=doubted, scale=scale, first_sea=first_sea)
                )
                found = verdicts[-1].suspicion
                # what has just made a sensor contradict all others is no cable, which was known before
                if found.is_explanation and not (is_early and found.culprit == CABLE):
                    return self._learnt_of(in_force, verdicts[-1])
            if is_early or (is_mixed and verdicts[0].suspicion.doubted == "depth"):
                return None
            return self._learnt_of(in_force, verdicts[0])

        self._work.begin(tick, judged)

    def _records(self) -> tuple[list[Sequence[RecordedTick]], bool]:
        """Return the records to judge, and whether the first is too old for the trouble to be known by it.

        What has changed on the way is explained from there on, or from where the loop has come to rest again.
        """
        record, shortest = self._estimation.record, round(SHORT_RECORD / self._dt)
        whole, since = record.ticks(), record.ticks(self._times.onset - 1)
        first = since if self._times.is_early else whole
        has_changed = shortest <= len(since) < len(whole) and shortest < len(first)
        return [first, since[-shortest:]] if has_changed else [first], len(since) < min(shortest, len(whole))

    @staticmethod
    def _learnt_of(in_force: DesignInForce, verdict: Verdict) -> Learnt:
        """Return the design for a `verdict`."""
        return Learnt(in_force.prepared_for(verdict.suspicion.parameters, verdict.suspicion.cable), verdict)

    def _says_nothing(self, suspicion: Suspicion) -> bool:
        """Tell whether a `suspicion` is no news, or acquits a sensor that is lost: what it reads is not on record."""
        observer = self._estimation.observer
        if suspicion.doubted:
            return suspicion.doubted == observer.doubted
        return not suspicion.culprit and bool(observer.doubted) and observer.gates[observer.doubted].is_lost

    def _take_verdict(self, tick: int, prepared: PreparedDesign, verdict: Verdict) -> list[str]:
        """Believe what was found of a sensor, and say which it is."""
        suspicion, estimation = verdict.suspicion, self._estimation
        was_doubted = estimation.observer.doubted
        if not estimation.record.reaches_to(verdict.last):
            return []  # the state has jumped since
        if self._says_nothing(suspicion):
            return []
        if not suspicion.culprit and not was_doubted:
            if estimation.surprise.time < SURPRISED_TIME:
                return []
            name, _ = estimation.surprise.worst
            sensors = (one.sensor for one in self._in_force.design.measurements if one.name == name)
            words = estimation.surprise.unexplained(next(sensors, name))
            estimation.surprise.excuse()
            return [words]
        matrix = self._in_force.take_sensors(prepared)
        followed = continued(verdict, estimation.record)
        estimation.adopt(self._in_force.design, matrix, followed, tick - 1, suspicion.doubted)
        self._times.note_found(tick)
        if not suspicion.culprit:
            return [f"{was_doubted} agrees with all others again"]
        verb = "as believed again" if suspicion.is_acquittal else "suspect"
        doubts = [f"{culprit} {verb}: {words}" for culprit, words in suspicion.findings.items()]
        self.corrected.update(suspicion.findings)
        if suspicion.state == MRU_BIAS:
            self.has_moved_tip = True
            self._seas_compared, self._seas_patience = -math.inf, FIRST_SEAS_PATIENCE
            estimation.forget_sea()
        if suspicion.culprit != "mru":
            estimation.surprise.excuse()
        return doubts


def _changes(before: SeaModelParameters, after: SeaModelParameters) -> str:
    """Return what has changed of a sea, in words; empty where it is the same to a decimal.

    Its height is not known yet where it stays as it was.
    """
    words = []
    for name, unit, old, new in (
        ("significant wave height", "m", before.significant_wave_height, after.significant_wave_height),
        ("peak period", "s", before.peak_period, after.peak_period),
        (
            "swell, significant wave height",
            "m",
            before.swell.significant_wave_height,
            after.swell.significant_wave_height,
        ),
        ("swell, peak period", "s", before.swell.peak_period, after.swell.peak_period),
    ):
        is_told = after.spectrum == "ochi_hubble" or not name.startswith("swell")
        if is_told and f"{old:.1f}" != f"{new:.1f}":
            words.append(f"{name} {new:.1f} {unit} (was {old:.1f})")
    return ", ".join(words)
