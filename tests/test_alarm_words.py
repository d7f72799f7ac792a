"""What an alarm says of compensation is what the controller does in the second after it, under every fault.

The modes are those that the controller reports, tick by tick: the words are held against what happened.
"""

from __future__ import annotations

import re

import numpy as np
import pytest
from heave_bags.analyse.events import COMPENSATES
from heave_bringup.closed_loop import ClosedLoop, LoopRecord, loop_parameters
from heave_bringup.pages.alarms import TABLES
from heave_bringup.scenarios import load_scenario
from heave_node.interface.alarm import LOOP
from heave_node.interface.codes import COMPENSATION_LOST

START, END = 60.0, 80.0
"""When the fault comes, and when the run ends [s]."""
SECOND = 1.0
"""Time over which the words must hold [s]."""

BRAKED = ("standby", "stopped", "emergency_stop", "off")
CLAIMS = {
    "Compensation continues": COMPENSATES,
    "Constant tension continues": ("constant_tension",),
    "Manual operation continues": ("manual",),
    "fading out": ("fade_out", "stopping", *BRAKED),
    "fades out": ("fade_out", "stopping", *BRAKED),
    "Winch is stopping": ("stopping", *BRAKED),
    "No compensation": BRAKED,
    "Compensation does not begin": BRAKED,
}
"""What an alarm may claim, and the modes in which that is true: all along if it continues, at some time else."""

SENSORS = ("mru", "depth", "encoder")
FAULTS = [
    *((sensor, kind) for sensor in SENSORS for kind in ("freeze", "spike", "jump", "scale", "nan")),
    *((sensor, kind) for sensor in ("mru", "depth") for kind in ("gap", "delay")),
    *(("winch", kind) for kind in ("gap", "delay", "drive", "emergency_stop")),
]
MAGNITUDES = {"scale": -1.0, "delay": 0.6, "spike": 1.0, "jump": 1.0}
PLACES = {
    "mru": "wave_vessel.mru.faults",
    "depth": "cable_sim.sensors.depth.faults",
    "encoder": "virtual_winch.encoder.faults",
    "winch": "virtual_winch.faults",
}
CONDITIONAL = re.compile(r"\bor\b|\bunless\b|\botherwise\b|\bif (?!it)")
"""Words of a consequence that leaves open what happens."""


def faulted(device: str, kind: str, scenario: str = "b2_calm_300") -> LoopRecord:
    place = PLACES[device]
    values = {"kind": kind, "start": START, "duration": 10.0, "magnitude": MAGNITUDES.get(kind, 0.0)}
    settings = [f"{place}.{name}=[{value}]" for name, value in values.items()]
    changed = load_scenario(scenario, settings=[*settings, f"all.duration={END}", "all.transient=1"])
    return ClosedLoop(loop_parameters(changed)).run()


def false_words(record: LoopRecord) -> list[str]:
    """Return the alarms of a run whose words were not true within a second: time, text and the modes there."""
    time, modes = record.column("time"), np.array(record.modes)
    wrong = []
    for at, alarm in record.alarms:
        after = set(modes[(time >= at) & (time < at + SECOND)])
        ended = [one for when, one in record.alarms if at < when <= at + SECOND and one.code == COMPENSATION_LOST]
        if ended and all(alarm.row.title not in str(one.values["reason"]) for one in ended):
            continue  # something else has ended it meanwhile, and says so
        for claim, allowed in CLAIMS.items():
            holds = after <= set(allowed) if "continues" in claim else after & set(allowed)
            if claim in alarm.text and not holds:
                wrong.append(f"{at:.2f} s {alarm}: {sorted(after)}")
    return wrong


@pytest.mark.slow
@pytest.mark.parametrize(("device", "kind"), FAULTS)
def test_what_an_alarm_says_of_compensation_is_true_in_the_second_after_it(device: str, kind: str) -> None:
    record = faulted(device, kind)
    assert any(at >= START for at, _ in record.alarms) or kind in ("spike", "jump", "delay")
    assert false_words(record) == []


def test_an_alarm_says_what_follows_in_this_run_not_what_may_follow() -> None:
    """An `or` leaves it to the reader; what states the mode without asking it may be false."""
    rows = [row for table in TABLES.values() for row in table.values()]
    assert [row.code for row in rows if CONDITIONAL.search(row.consequence)] == []
    controller = [row for row in rows if f"{{{LOOP}}}" in row.consequence]
    assert len(controller) > 50
    stated = [row.code for row in controller if re.search(r"continues|fades out|stops\b", row.consequence)]
    assert stated == ["COMMANDS_CUT"], "that is the winch's own watchdog"
