"""Learning in a running loop that the encoder reads a wrong scale, or the other way.

It is taken so from then on, and compensation goes on.
"""

from __future__ import annotations

from winch_controller_node.design_in_force import DesignInForce
from winch_controller_node.estimation.depth_witness import WINDOWS
from winch_controller_node.estimation.loop_estimation import LoopEstimation
from winch_controller_node.identification.encoder_scale import (
    CONTRARY_PERIOD,
    CONTRARY_TIME,
    JUDGED_PERIOD,
    Scale,
    ScaleJudge,
    Sent,
    encoder_scale,
    is_contrary,
    is_off,
    is_right_way,
    is_sudden,
    is_true,
    winch_gain,
)
from winch_controller_node.identification.suspicions import RIGHT_SCALE
from winch_controller_node.supervision.watch.winch_watch import WinchWatch

LONGEST_ASIDE = 20.0
"""Time in which it must be known what an encoder reads that goes the other way [s]: it may be the winch that does."""

BEGINNING = 15.0
"""Time since the winch began to move in which it may well be [s]: the sign of one was wrong from the start."""

LOOKS = 2
"""An encoder that has gone the right way goes the other only once that has been seen so often in a row.

A drum that lags behind turns back late.
"""

KNOWN_TIME, KNOWN = 10.0, 0.8
"""Time constant [s] of the share of looks in which the encoder reads what the winch was sent, and the share from which
on the winch is known: what the encoder then reads otherwise is the encoder's.
"""

CONTRARY_WORDS = "goes the other way than the winch {}"
SUDDEN_WORDS = "reads far more or less than the winch {}"
"""What an encoder does that is set aside, now or before."""

MORE_PLAY = 1.5
"""Play over what was told before that is told anew."""


class EncoderLearning:
    """Compares what the winch was sent with what encoder and depth sensor read of it.

    Parameters
    ----------
    in_force, estimation, winch : what goes on with what is learnt

    Attributes
    ----------
    is_contrary : the drum goes the other way, or the encoder does: nothing can be done with it
    has_found : that the encoder is wrong, in this tick
    """

    def __init__(self, in_force: DesignInForce, estimation: LoopEstimation, winch: WinchWatch) -> None:
        self._in_force, self._estimation, self._winch = in_force, estimation, winch
        self._dt = in_force.design.tick_period
        self._told_winch = in_force.parameters.winch
        self._judge, self._gain_judge = ScaleJudge(), ScaleJudge()
        self._gain = 1.0  # of the winch, as encoder and depth sensor have shown
        self._aside_time = self._moving_time = 0.0
        self._last = -1
        self._was_right, self._looks = False, 0
        self._true_share = 0.0
        self._words = CONTRARY_WORDS
        self._told_play = 0.0
        self.is_contrary = False
        self.has_found = False

    @property
    def doubts_encoder(self) -> bool:
        """Tell whether what the encoder reads says nothing now, of the winch or of other sensors."""
        observer = self._estimation.observer
        return self._judge.doubts or observer.doubted == "encoder" or observer.gates["encoder"].is_lost

    @property
    def inhibition(self) -> str:
        """Why compensation must be off until an operator asks for it; empty: it need not."""
        if not self.is_contrary:
            return ""
        what, at = self._words.format("is sent"), "the sign" if self._words == CONTRARY_WORDS else "sign and scale"
        return f"the encoder {what}, and which of them is wrong is not known: look at {at} of both"

    def trust_encoder(self) -> None:
        """Try an encoder again that was set aside: an operator asks for it."""
        self.is_contrary = False
        if self._estimation.observer.doubted == "encoder":
            self._estimation.observer.doubt("")

    def follow(self, tick: int) -> list[str]:
        """Compare before a `tick` in which the winch moves, and return what has been found, in words."""
        self.has_found = False
        self._moving_time = self._moving_time + self._dt if tick == self._last + 1 else 0.0
        self._last = tick
        words = self._tell_play() + self._watch_direction(tick)
        is_known = self._estimation.knows_tip and self._estimation.observer.doubted != "depth"
        if not is_known or tick % max(1, round(JUDGED_PERIOD / self._dt)) != 0:
            return words
        sent, witness = [self._sent(time) for time in WINDOWS], self._estimation.depth_witness
        seen = witness.seen() if is_off(sent) else []
        found = self._judge.judge(encoder_scale(sent, seen) if seen else None)
        gain = self._gain_judge.judge(winch_gain(sent, seen) if seen else None)
        self._gain *= 1.0 if gain is None else gain.value
        return words if found is None else [self._rescale_encoder(found, tick)]

    def _is_as_found(self) -> bool:
        """Tell whether the encoder does no more than a winch with the gain and limits that were found before."""
        sent = self._winch.sent(CONTRARY_TIME, as_found=True)
        return sent is not None and not is_contrary(sent, was=False) and not is_sudden(sent, was=False)

    def _sent(self, time: float) -> Sent | None:
        """Return what the encoder reads of what the winch was sent over a `time` [s], and does; None: unknown."""
        sent = self._winch.sent(time)
        return None if sent is None else sent._replace(share=sent.share / self._gain)

    def _rescale_encoder(self, found: Scale, tick: int) -> str:
        """Take the encoder to read as was `found`, forget what was learnt from it, and say so."""
        self._estimation.rescale_encoder(found.value, found.seen, tick - 1)
        self._winch.forget()
        self._in_force.take_limits(self._told_winch)
        self.has_found = True
        scale = self._estimation.observer.encoder.scale
        if abs(scale - 1.0) < RIGHT_SCALE:
            return "encoder as believed again: it reads what the winch was sent and the depth sensor sees"
        return (
            f"encoder suspect: it reads {scale:.2f} times what the winch was sent and the depth sensor sees, and is "
            "taken so from now on: look at its scale and sign, and at the radius of the drum"
        )

    def _tell_play(self) -> list[str]:
        """Say once that what seemed a frozen encoder is the play of its gear."""
        encoder = self._estimation.observer.encoder
        play = encoder.play
        if not encoder.shows_play or play <= MORE_PLAY * self._told_play:
            return []
        self._told_play = play
        return [
            f"encoder suspect: its gear has {play:.2f} m of play or more, for which it seemed frozen where the drum "
            "turned round: it is waited for from now on: look at its coupling"
        ]

    def _watch_direction(self, tick: int) -> list[str]:
        """Set an encoder aside that goes the other way than the winch was sent, until it is known which is wrong."""
        observer = self._estimation.observer
        was = observer.doubted == "encoder"
        self._aside_time = self._aside_time + self._dt if was else 0.0
        self.is_contrary |= self._aside_time > LONGEST_ASIDE
        if tick % max(1, round(CONTRARY_PERIOD / self._dt)) != 0 or observer.doubted not in ("", "encoder"):
            return []
        sent = self._sent(CONTRARY_TIME)
        if sent is None:
            return []
        self._was_right |= is_right_way(sent)
        self._true_share += CONTRARY_PERIOD / KNOWN_TIME * (is_true(sent) - self._true_share)
        knows_winch = was or self._true_share > KNOWN
        goes_back = is_contrary(sent, was=was)
        is_now = goes_back or (knows_winch and is_sudden(sent, was=was))
        if is_now and not was:
            is_now = not self._is_as_found()
        self._looks = self._looks + 1 if is_now else 0
        if is_now == was or (is_now and self._was_right and self._looks < LOOKS):
            return []
        if was:
            observer.doubt("")
            return []
        self._estimation.set_encoder_aside(sent.payout, tick - 1)
        self.is_contrary = self._moving_time < BEGINNING and not self._was_right
        self.has_found = True
        self._words = CONTRARY_WORDS if goes_back else SUDDEN_WORDS
        return [f"encoder suspect: it {self._words.format('was sent')}: set aside while they are compared"]
