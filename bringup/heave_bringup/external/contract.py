"""The contract of external nodes: what a replacement of a node must publish, may receive, and must keep to.

One table, from which the page `docs/contract.md` is written (`python -m heave_bringup.external.contract`) and against
which `heave check` holds a live node. Topics, types and times come from the code that runs, words from `contract.yaml`.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from cable_sim_node.winch.parameters import WinchParameters
from heave_node.crane.pose import LARGEST, RATES
from heave_node.files.bounded_yaml import parse_yaml
from heave_node.interface import sensors, topics
from heave_node.interface.topic import Topic
from heave_node.ros.participant import CATCH_UP_LIMIT
from heave_node.run_parameters import RunParameters
from wave_vessel_node.parameters import WaveVesselParameters
from winch_controller_node.beliefs.beliefs import LATENCY
from winch_controller_node.core.supervision.modes import WAIT
from winch_controller_node.node_parameters import WinchControllerParameters

TICK = RunParameters().tick_period
WINCH = WinchParameters()
WATCHDOG = WINCH.command_timeout
CONTROLLER = WinchControllerParameters()
VALUES = {
    "tick": TICK,
    "winch": WINCH,
    "modes": CONTROLLER.modes,
    "boom_tip_height": WaveVesselParameters().boom_tip_height,
    "latency": LATENCY,
    "wait": WAIT,
    "catch_up": CATCH_UP_LIMIT,
}
"""What the words of the file may name in braces."""
WORDS: Mapping[str, Any] = parse_yaml(Path(__file__).with_suffix(".yaml").read_text(encoding="utf-8"))


@dataclass(frozen=True)
class Port:
    """A topic of an external node."""

    topic: Topic  # its name, type and role
    rate: float  # lowest rate at which the loop works well [Hz]; 0: none is required
    is_required: bool  # the run does not begin without it
    meaning: str  # what it says, in words
    # fields that must be finite numbers, each with the largest magnitude that is plausible in its unit
    numbers: tuple[tuple[str, float], ...] = ()
    counter: str = ""  # field that counts up by one; "" for none
    may_be_missing: tuple[str, ...] = ()  # those of the numbers that are NaN where they are not measured


@dataclass(frozen=True)
class Contract:
    """What takes the place of one node; the file says the rest under its name."""

    node: str  # of the suite that is replaced
    publishes: tuple[Port, ...]  # topics out
    hears: tuple[Port, ...]  # topics in

    def words(self, about: str) -> str:
        """Return what the file says `about` it: what it is, when_late, handshake, advice; "" where it says nothing."""
        text: str = WORDS["nodes"][self.node].get(about, "").replace("\n", "\n\n")
        return text.format(**VALUES, release=WORDS["release"].rstrip(), sensor=SENSORS_OF_SHIP[0].topic.name)


CLOCK = Port(topics.CLOCK, 1.0 / TICK, False, "simulated time: the start of each tick, used for stamps")
COMMAND = Port(
    topics.WINCH_COMMAND,
    1.0 / TICK,
    True,
    "set-points of payout and payout rate, brake, sequence number",
    (("payout", 1e4), ("payout_rate", 10.0)),
    "sequence",
)
STATE = Port(
    topics.WINCH_STATE,
    1.0 / TICK,
    True,
    "encoder payout and payout rate, newest accepted command, brake, fault and its release condition; NaN if unknown",
    (("encoder_payout", sensors.LARGEST_PAYOUT), ("encoder_payout_rate", 10.0)),
)
MRU = Port(
    topics.MRU,
    10.0,
    True,
    sensors.MRU.meaning,
    sensors.MRU.largest,
    "sequence",
    sensors.MRU.may_be_missing,
)
HEAVE_PREVIEW = Port(
    topics.HEAVE_PREVIEW,
    0.0,
    False,
    "optional: predicted boom-tip `heave` at the times `ahead` after the stamp, from measurements up-wave or by radar",
    (("heave_sigma", 10.0),),
)
CRANE_POSE = Port(
    topics.CRANE_POSE,
    5.0,
    False,
    "optional: joint positions and rates of the crane, which give the position of the boom tip; NaN where not measured",
    (*LARGEST, *((rate, 10.0) for rate in RATES)),
    may_be_missing=(*(joint for joint, _ in LARGEST), *RATES),
)
BOOM_TIP = Port(
    topics.BOOM_TIP,
    1.0 / TICK,
    True,
    "motion of the boom tip, for the simulated cable",
    (("position.z", 1e3), ("velocity.z", 30.0), ("acceleration.z", 100.0)),
)
WAVE_COMPONENTS = Port(
    topics.WAVE_COMPONENTS,
    0.0,
    False,
    "optional, once: wave components, for the water motion at cable and load; `cable_sim.wave.source: sea` needs them",
    (("ramp", 1e4),),
)
OBSERVATIONS = Port(
    topics.CONTROLLER_OBSERVATIONS,
    0.0,
    False,
    "once a second, a batch of ticks: commands, checked readings, winch state, nominal parameters",
)
BELIEFS = Port(
    topics.CONTROLLER_BELIEFS,
    0.0,
    False,
    "the answer to a batch: values that differ from nominal, findings, and a design for these values",
    (("authority", 1.0),),
)
SENSORS_OF_SHIP = tuple(
    Port(sensor.topic, 0.0, False, sensor.meaning, sensor.largest)
    for sensor in sensors.SENSORS.values()
    if sensor.topic.publisher == "cable_sim"
)

CONTRACTS: tuple[Contract, ...] = (
    Contract(
        "winch_controller",
        publishes=(COMMAND, OBSERVATIONS),
        hears=(CLOCK, MRU, HEAVE_PREVIEW, CRANE_POSE, STATE, *SENSORS_OF_SHIP, BELIEFS),
    ),
    Contract("winch_adviser", publishes=(BELIEFS,), hears=(OBSERVATIONS,)),
    Contract(
        "virtual_winch",
        publishes=(STATE,),
        hears=(CLOCK, COMMAND, Port(topics.CABLE_STATE, 0.0, False, "tension (simulated cables only)")),
    ),
    Contract("wave_vessel", publishes=(MRU, BOOM_TIP, WAVE_COMPONENTS, HEAVE_PREVIEW, CRANE_POSE), hears=(CLOCK,)),
    Contract("cable_sim", publishes=SENSORS_OF_SHIP, hears=(CLOCK,)),
)
PARTS = (MRU, CRANE_POSE, *SENSORS_OF_SHIP)
CONTRACT_OF = {contract.node: contract for contract in CONTRACTS} | {
    port.topic.name: Contract(port.topic.name, (replace(port, is_required=True),), (CLOCK,)) for port in PARTS
}
"""Contracts of nodes, and of single sensors by their topics."""


def page() -> str:
    """Return the whole contract as Markdown."""
    introduction, lockstep = (WORDS[part].format(**VALUES) for part in ("introduction", "lockstep"))
    return "\n".join([introduction, *map(_section, CONTRACTS), lockstep])


def _section(contract: Contract) -> str:
    lines = [f"## `{contract.node}`: {contract.words('what')}\n", *_table(contract.publishes)]
    lines += ["", f"**Reads** {_read(contract)}."]
    for about, title in (("advice", "How"), ("when_late", "When late"), ("handshake", "Brake and faults")):
        if text := contract.words(about):
            lines += ["", f"**{title}.** {text}"]
    return "\n".join([*lines, ""])


def _table(ports: Sequence[Port]) -> list[str]:
    """Return the table of what a node publishes."""
    rows = ["|publishes|type|rate|required|meaning|", "|---|---|---|---|---|"]
    for port in ports:
        rate, required = f"{port.rate:g} Hz" if port.rate else "-", "yes" if port.is_required else "no"
        rows.append(f"|`{port.topic.name}`|`{port.topic.type}`|{rate}|{required}|{port.meaning}|")
    return rows


def _read(contract: Contract) -> str:
    """Return what a node may read: type and meaning of a topic that no other section of the page has stand here."""
    published = {CLOCK.topic.name, *(port.topic.name for one in CONTRACTS for port in one.publishes)}
    return ", ".join(
        f"`{port.topic.name}`" + ("" if port.topic.name in published else f" (`{port.topic.type}`: {port.meaning})")
        for port in contract.hears
    )


def main() -> None:
    """Print the page."""
    sys.stdout.write(page())


if __name__ == "__main__":
    main()
