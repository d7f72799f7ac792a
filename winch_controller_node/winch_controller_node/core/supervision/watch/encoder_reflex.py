"""The reflex about the encoder, in words: a reversed one is set aside within a second, in C++ (encoder_reflex.cpp).

A loop that uses it is unstable. Its scale is identified by the adviser.
"""

from __future__ import annotations

from heave_core.law import put
from heave_core.library import new
from heave_core.watch_table import REFLEX_DESIGN, REFLEX_STATE
from heave_node.interface.alarm import Alarm

from winch_controller_node.core.estimation.second_filter import SecondFilter
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.interface.sensors import MEASURED_WORDS

LOST_TIME = 1.0
"""An encoder that is lost for so long is lost indeed [s]; one with play is still for a moment when the drum turns."""

LOOKED_EVERY = 0.1
"""Time from one look to the next [s]."""

KNOWN_TIME = 10.0
"""Time constant of the share of looks in which the encoder reads what was ordered [s]."""

CONSTANTS = {
    "longest_aside": 20.0,  # it may be the winch that is reversed
    "beginning": 15.0,  # the sign of either may have been wrong from the start
    "looks": 2,
    "separated": 5.0,
    "learnt": LOOKED_EVERY / KNOWN_TIME,
    "known": 0.8,
    "straight": 0.15,  # a weak drum lags behind
    "reversed": -0.2,
    "not_reversed": 0.5,
    "less": 0.6,
    "more": 1.6,
    "not_less": 0.75,
    "not_more": 1.3,
    "error": 0.1,  # a weaker or slower winch is further off
}
"""Constants of the reflex: meanings and units are in the core's table, REFLEX_DESIGN."""


class EncoderReflex:
    """What has been found of the direction of the encoder.

    `tick_period` : [s]

    Attributes
    ----------
    design, state : arrays of one of the core's structures; records : the two by name
    """

    def __init__(self, tick_period: float) -> None:
        self.design, self.state = new(REFLEX_DESIGN), new(REFLEX_STATE)
        self.records = {"reflex": self.design, "reflex_state": self.state}
        ticks = {"lost_ticks": round(LOST_TIME / tick_period), "look_ticks": max(1, round(LOOKED_EVERY / tick_period))}
        put(self.design, {"tick_period": tick_period, **ticks, **CONSTANTS})
        put(self.state, {"last": -1, "is_reversed": 1})
        self._named: Alarm | None = None

    def take_delay(self, another_count: float) -> None:
        """Take the time from a jump of the count to the first order in the new one, `another_count`, for that [s]."""
        self.design["another_count"] = another_count

    @property
    def is_unresolved(self) -> bool:
        """Tell whether drum or encoder go the other way, and which is not known: nothing can be done with the winch."""
        return bool(self.state["is_unresolved"][0])

    @property
    def named(self) -> Alarm | None:
        """Which of drive and encoder was found at fault; None: neither."""
        return self._named if self.state["is_named"][0] else None

    @property
    def inhibition(self) -> Alarm | None:
        """Why compensation must be off until an operator asks for it; None: it need not."""
        if not self.is_unresolved:
            return None
        names = "DRUM_OR_ENCODER: unresolved reversal", "DRUM_OR_ENCODER: unresolved scale"
        return self.named or ALARMS.alarm(self._wrong(*names))

    @property
    def alarm(self) -> Alarm:
        """Why the encoder was set aside."""
        return ALARMS.alarm(self._wrong("DRUM_OR_ENCODER: reversed", "DRUM_OR_ENCODER: scale"))

    def _wrong(self, direction: str, scale: str) -> str:
        return direction if self.state["is_reversed"][0] else scale

    def restart(self) -> None:
        """Restart: an operator asks for the encoder to be tried, or another scale is assumed."""
        put(self.state, dict.fromkeys(("is_unresolved", "is_named", "looks", "aside_time"), 0))

    def take_evidence(self, by_count: SecondFilter | None) -> None:
        """Take in the evidence of the filter that goes by the count, `by_count`; None: there is none."""
        if by_count is not None:
            self.state["nats"] = by_count.nats

    def judge(self, by_count: SecondFilter) -> Alarm:
        """Return which of drive and encoder is at fault, as a sensor beside them shows by evidence of `by_count`."""
        is_drive = by_count.nats > 0.0
        witness = by_count.witness[0] if is_drive else by_count.witness_against
        code = "DRIVE_AT_FAULT" if is_drive else "SENSOR_LOST, ENCODER: at fault"
        self._named = ALARMS.alarm(code, witness=MEASURED_WORDS[witness])
        return self._named
