"""What an alarm says of compensation is what the controller does in the second after it, under every fault.

The modes are those that the controller reports, tick by tick: the words are held against what happened.
"""

from __future__ import annotations

import re
from types import SimpleNamespace

import numpy as np
import pytest
from heave_bringup.pages.alarms import TABLES
from heave_node.interface.alarm import LOOP
from winch_controller_node.core.supervision.modes import DAMPED, LOOP_WORDS

from tests.campaigns.fault_matrix.words import CLAIMS, false_words
from tests.loops import fault, loop_of

START, END = 60.0, 80.0
"""When the fault comes, and when the run ends [s]."""
SENSORS = ("mru", "depth", "encoder")
FAULTS = [
    *((sensor, kind) for sensor in SENSORS for kind in ("freeze", "spike", "jump", "scale", "nan")),
    *((sensor, kind) for sensor in ("mru", "depth") for kind in ("gap", "delay")),
    *(("winch", kind) for kind in ("gap", "delay", "drive", "emergency_stop")),
]
MAGNITUDES = {"scale": -1.0, "delay": 0.6, "spike": 1.0, "jump": 1.0}
CONDITIONAL = re.compile(r"\bor\b|\bunless\b|\botherwise\b|\bif (?!it)")
"""Words of a consequence that leaves open what happens."""


@pytest.mark.slow
@pytest.mark.parametrize(("device", "kind"), FAULTS)
def test_what_an_alarm_says_of_compensation_is_true_in_the_second_after_it(device: str, kind: str) -> None:
    settings = fault(device, kind, START, 10.0, MAGNITUDES.get(kind, 0.0))
    record = loop_of("b2_calm_300", settings, duration=END, transient=1).run()
    assert any(at >= START for at, _ in record.alarms) or kind in ("spike", "jump", "delay")
    assert false_words(record) == []


@pytest.mark.slow
def test_a_frozen_encoder_keeps_its_alarm_until_a_request_tries_it_and_is_named_once() -> None:
    loop = loop_of("b2_calm_300", fault("encoder", "freeze", START))
    raised: list[str] = []

    def standing(seconds: float) -> str:
        for _ in range(round(seconds / 0.05)):
            outputs, _ = loop.step()
            raised.extend(alarm.name for alarm in outputs.alarms)
        (encoder,) = [one for one in outputs.report.sensors if one.sensor == "encoder"]
        return encoder.alarm.name if encoder.alarm else ""

    controller = loop.controller
    assert (standing(100.0), controller.mode.value) == ("SENSOR_LOST, ENCODER: at fault", "stopped")
    assert raised.count("SENSOR_LOST, ENCODER: at fault") == 1
    controller.ask_for_mode("standby")
    assert (standing(5.0), controller.mode.value) == ("SENSOR_LOST, ENCODER: at fault", "standby")
    assert controller.ask_for_mode("compensating").startswith(("standby", "compensating")), "it is taken at once"
    said_before = len(raised)
    assert standing(60.0)
    assert controller.mode.value in ("fade_out", "stopping", "stopped"), "it was tried, and is still frozen"
    said = [name for name in raised[said_before:] if "ENCODER" in name]
    assert said and len(said) == len(set(said)), "once more, whether or not the depth tells drum from encoder this time"


def test_an_alarm_says_what_follows_in_this_run_not_what_may_follow() -> None:
    """An `or` leaves it to the reader; what states the mode without asking it may be false."""
    rows = [row for table in TABLES.values() for row in table.values()]
    assert [row.code for row in rows if CONDITIONAL.search(row.consequence)] == []
    controller = [row for row in rows if f"{{{LOOP}}}" in row.consequence]
    assert len(controller) > 50
    stated = [row.code for row in controller if re.search(r"continues|fades out|stops\b", row.consequence)]
    assert stated == ["COMMANDS_CUT"], "that is the winch's own watchdog"


@pytest.mark.parametrize("mode", ["compensating", "fade_out", "constant_tension", "manual", "stopping", "standby"])
def test_words_that_the_modes_belie_are_found(mode: str) -> None:
    time = np.arange(0.0, 3.0, 0.05)
    for claim, allowed in CLAIMS.items():
        loop = SimpleNamespace(code="SENSOR_LOST, MRU", text=f"SENSOR_LOST, MRU. {claim}.")
        record = SimpleNamespace(column=lambda _: time, modes=[mode] * time.size, alarms=[(1.0, loop)])
        assert bool(false_words(record)) == (mode not in allowed), claim
        assert false_words(record, begin=2.0) == []


def test_each_claim_is_one_that_alarms_make() -> None:
    """A claim that no alarm words any more would be looked for in vain."""
    texts = " ".join(row.consequence for table in TABLES.values() for row in table.values())
    texts += " ".join([DAMPED, *LOOP_WORDS.values()])
    assert [claim for claim in CLAIMS if claim not in texts] == []
