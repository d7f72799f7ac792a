"""The reflex about the encoder: a reversed one is set aside within a second.

A loop that uses it is unstable. Its scale is identified by the adviser.
"""

from __future__ import annotations

from enum import Enum

from heave_node.interface.alarm import Alarm

from winch_controller_node.core.estimation.second_filter import SecondFilter
from winch_controller_node.core.supervision.watch.drum_watch import Ordered
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.interface.sensors import MEASURED_WORDS

LOOKED_EVERY = 0.1
"""Time from one look to the next [s]."""

LONGEST_ASIDE = 20.0
"""Time in which it must be known what an encoder reads that is set aside [s]: it may be the winch that is reversed."""

BEGINNING = 15.0
"""Time since the winch began to move in which it may well be [s]: the sign of one was wrong from the start."""

LOOKS = 2
"""An encoder that has gone the right way is set aside once it has been wrong in so many looks running.

A drum that lags behind turns back late.
"""

SEPARATED = 5.0
"""Evidence of a third sensor for the count, or for the commands, at which drive or encoder is named [nats]."""

KNOWN_TIME, KNOWN = 10.0, 0.8
"""Time constant [s] of the share of looks in which the encoder reads what was ordered, and the share from which on the
winch is known: what the encoder then reads otherwise is the encoder's."""


class Act(Enum):
    """What is to be done."""

    NOTHING = ""
    SET_ASIDE = "set aside"
    USE_AGAIN = "use again"


class EncoderReflex:
    """Watches the direction of the encoder.

    `tick_period` : [s]
    """

    def __init__(self, tick_period: float) -> None:
        self._dt = tick_period
        self._aside_time = self._moving_time = 0.0
        self._last = -1
        self._was_right, self._looks = False, 0
        self._true_share = 0.0
        # drum or encoder go the other way, and which of them is not known: nothing can be done with the winch
        self.is_unresolved = False
        self._is_reversed = True
        self.named: Alarm | None = None  # which of drive and encoder was found at fault; None: neither

    @property
    def inhibition(self) -> Alarm | None:
        """Why compensation must be off until an operator asks for it; None: it need not."""
        if not self.is_unresolved:
            return None
        if self.named is not None:
            return self.named
        return ALARMS.alarm(
            "DRUM_OR_ENCODER: unresolved reversal" if self._is_reversed else "DRUM_OR_ENCODER: unresolved scale"
        )

    @property
    def alarm(self) -> Alarm:
        """Why the encoder was set aside."""
        return ALARMS.alarm("DRUM_OR_ENCODER: reversed" if self._is_reversed else "DRUM_OR_ENCODER: scale")

    def restart(self) -> None:
        """Restart: an operator asks for the encoder to be tried, or another scale is assumed."""
        self.is_unresolved, self.named = False, None
        self._looks, self._aside_time = 0, 0.0

    @property
    def is_separated(self) -> bool:
        """Tell whether drive or encoder has been named."""
        return self.named is not None

    def agrees(self) -> None:
        """Note that count and commands agree again."""
        if not self.is_unresolved:
            self.named = None

    def separate(self, by_count: SecondFilter) -> Alarm | None:
        """Return which of drive and encoder is at fault, once a sensor beside them shows it; None: not yet.

        `by_count` : filter that goes by the count, beside the active one that goes by the commands
        """
        nats = by_count.nats
        if abs(nats) < SEPARATED:
            return None
        witness = by_count.witness[0] if nats > 0.0 else by_count.witness_against
        self.named = ALARMS.alarm(
            "DRIVE_AT_FAULT" if nats > 0.0 else "SENSOR_LOST, ENCODER: at fault", witness=MEASURED_WORDS[witness]
        )
        self.is_unresolved |= nats > 0.0
        return self.named

    def is_due(self, tick: int) -> bool:
        """Return whether a look is due before a `tick`."""
        return tick % max(1, round(LOOKED_EVERY / self._dt)) == 0

    def look(self, tick: int, ordered: Ordered | None, *, is_aside: bool) -> Act:
        """Return what is to be done before a `tick` in which the winch moves; `is_aside` : the encoder is set aside.

        `ordered` : what the encoder reads of what was ordered; None: unknown, or no look is due
        """
        self._moving_time = self._moving_time + self._dt if tick == self._last + 1 else 0.0
        self._last = tick
        self._aside_time = self._aside_time + self._dt if is_aside else 0.0
        self.is_unresolved |= self._aside_time > LONGEST_ASIDE
        if ordered is None or not self.is_due(tick):
            return Act.NOTHING
        self._was_right |= ordered.is_right_way
        self._true_share += LOOKED_EVERY / KNOWN_TIME * (ordered.is_true - self._true_share)
        goes_back = ordered.is_reversed(was=is_aside)
        knows_winch = is_aside or self._true_share > KNOWN
        is_wrong = goes_back or (knows_winch and ordered.is_sudden(was=is_aside))
        self._looks = self._looks + 1 if is_wrong else 0
        if is_wrong == is_aside or (is_wrong and self._was_right and self._looks < LOOKS):
            return Act.NOTHING
        if is_aside:
            return Act.USE_AGAIN
        self._is_reversed = goes_back
        self.is_unresolved = self._moving_time < BEGINNING and not self._was_right
        return Act.SET_ASIDE
