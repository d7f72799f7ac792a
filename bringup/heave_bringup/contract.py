"""The contract of external nodes: what a replacement of a node must publish, may receive, and must keep to.

One table, from which the page `docs/contract.md` is written (`python -m heave_bringup.contract`) and against which
`heave check` holds a live node. Topics, types, times and message texts come from the code that runs.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass

from cable_sim_node.winch.parameters import WinchParameters
from heave_bags.cdr.layout import SEPARATOR
from heave_bags.mcap.definitions import schema_text
from heave_node import topics
from heave_node.run_parameters import RunParameters
from heave_node.sensors import SENSORS
from heave_node.topic import Role, Topic
from winch_controller_node.node_parameters import WinchControllerParameters

TICK = RunParameters().tick_period
WATCHDOG = WinchParameters().command_timeout
MODES = WinchControllerParameters().modes
COAST, RESUME = MODES.coast_time, MODES.resume_time


@dataclass(frozen=True)
class Port:
    """A topic of an external node.

    Attributes
    ----------
    topic : its name, type and role
    rate : lowest rate at which the loop works well [Hz]; 0: none is required
    is_required : the run does not begin without it
    meaning : what it says, in words
    numbers : fields that must be finite numbers, each with the largest magnitude that is plausible in its unit
    counter : field that counts up by one; "" for none
    """

    topic: Topic
    rate: float
    is_required: bool
    meaning: str
    numbers: tuple[tuple[str, float], ...] = ()
    counter: str = ""


@dataclass(frozen=True)
class Contract:
    """What takes the place of one node.

    Attributes
    ----------
    node : of the suite that is replaced
    what : takes its place, in words
    publishes, hears : topics out and in
    when_late : what happens when its messages are late or stop
    handshake : how it and its fellow agree on brake and faults; "" where there is nothing to agree on
    """

    node: str
    what: str
    publishes: tuple[Port, ...]
    hears: tuple[Port, ...]
    when_late: str
    handshake: str = ""


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
    "encoder's reading of payout and of its rate, newest command accepted, brake, fault; NaN where unknown",
    (("encoder_payout", 1e4), ("encoder_payout_rate", 10.0)),
)
MRU = Port(
    topics.MRU,
    10.0,
    True,
    "heave, heave rate and acceleration of the boom tip, roll, pitch, status, sequence number",
    (("heave", 30.0), ("heave_rate", 30.0), ("roll", 1.6), ("pitch", 1.6)),
    "sequence",
)
BOOM_TIP = Port(
    topics.BOOM_TIP,
    1.0 / TICK,
    True,
    "motion of the boom tip, for the simulated cable; an MRU alone can provide it",
    (("position.z", 1e3), ("velocity.z", 30.0), ("acceleration.z", 100.0)),
)
SENSORS_OF_SHIP = tuple(
    Port(sensor.topic, 0.0, False, f"readings of {name}")
    for name, sensor in SENSORS.items()
    if sensor.topic.publisher == "cable_sim"
)

CONTRACTS: tuple[Contract, ...] = (
    Contract(
        "winch_controller",
        "a controller",
        publishes=(COMMAND,),
        hears=(CLOCK, MRU, STATE, *SENSORS_OF_SHIP),
        when_late=f"A winch that gets no fresh command for {WATCHDOG:g} s stops with its own deceleration and brakes.",
        handshake="The winch starts with its brake on. A fresh command with `brake: false` releases it. A fault is "
        "latched: it is acknowledged by a fresh command with `brake: true` and released by a fresh one with "
        "`brake: false`, the drum at rest. `sequence` counts up from 1; a command whose number is not above the newest "
        "one accepted is rejected.",
    ),
    Contract(
        "virtual_winch",
        "a winch drive",
        publishes=(STATE,),
        hears=(CLOCK, COMMAND, Port(topics.CABLE_STATE, 0.0, False, "tension, of simulated cables only")),
        when_late="The simulated cable coasts the drum to rest after 0.5 s without a state. The controller takes the "
        f"encoder for lost, runs on prediction for {COAST:g} s, then fades out and stops the winch.",
        handshake=f"Without a fresh command for {WATCHDOG:g} s the drive must stop by itself, brake, and say "
        "`fault: 1` (FAULT_COMMAND_TIMEOUT). A set-point that is not finite: stop, brake, `fault: 2`. A fault is "
        "latched until a fresh command with `brake: true` and then one with `brake: false`. `command_sequence` echoes "
        "the number of the newest command in effect: lateness is measured by it.",
    ),
    Contract(
        "wave_vessel",
        "a motion reference unit, or a vessel with one",
        publishes=(MRU, BOOM_TIP),
        hears=(CLOCK,),
        when_late=f"The controller runs on prediction for {COAST:g} s, then fades out and stops the winch; it resumes "
        f"when readings have been good for {RESUME:g} s. The simulated cable coasts its upper end to rest after 0.5 s.",
    ),
)
CONTRACT_OF = {contract.node: contract for contract in CONTRACTS}


def qos_words(topic: Topic) -> str:
    """Return the quality of service of a topic in words."""
    return "reliable, transient local, depth 1" if topic.role is Role.LATCHED else "reliable, volatile"


def page() -> str:
    """Return the whole contract as Markdown."""
    parts = [INTRODUCTION, *map(_section, CONTRACTS), "## Messages\n", *map(_message, _types())]
    return "\n".join(parts)


INTRODUCTION = f"""# The contract of external nodes

This page is generated by `python -m heave_bringup.contract` from the code that runs.
`heave run SCENARIO --pacing realtime --external NODE` starts all nodes but NODE, and waits for a publisher of each
topic that is marked *required*. `heave check --external NODE` checks your live node against this page.
`examples/` holds a node of some 60 lines for each.

- **Units** are SI, in every field. **Signs**: payout positive lets cable out and lowers the unit; heave is positive up,
  depth positive down.
- **Clock**: stamps are simulated time. Take it from `/clock` and stamp each message with the newest one. A tick lasts
  {TICK:g} s unless the scenario says otherwise. The ticks start when all nodes are ready.
- **Quality of service**: publish and subscribe as the table says. A best-effort publisher does not match a reliable
  subscriber.
- **Names** are relative: a namespace or a remapping works on either side. The name of your node is free.
- **Reach**: the same `ROS_DOMAIN_ID`. Nodes are found on this machine alone, unless `heave` is given `--network`.
- A topic has one publisher.
"""


def _section(contract: Contract) -> str:
    lines = [f"## `{contract.node}`: {contract.what}\n", *_table(contract)]
    lines += ["", f"**When late.** {contract.when_late}"]
    if contract.handshake:
        lines += ["", f"**Brake and faults.** {contract.handshake}"]
    return "\n".join([*lines, ""])


def _table(contract: Contract) -> list[str]:
    rows = ["| | topic | type | quality of service | rate | required | meaning |", "|---|---|---|---|---|---|---|"]
    for direction, ports in (("out", contract.publishes), ("in", contract.hears)):
        for port in ports:
            rate = f"{port.rate:g} Hz" if port.rate else "-"
            required = "yes" if port.is_required and direction == "out" else "no"
            cells = (direction, f"`{port.topic.name}`", f"`{port.topic.type}`", qos_words(port.topic), rate, required)
            rows.append(f"| {' | '.join(cells)} | {port.meaning} |")
    return rows


def _types() -> list[str]:
    """Return the suite's own message types of all contracts, each once."""
    ports = [port for contract in CONTRACTS for port in (*contract.publishes, *contract.hears)]
    return list(dict.fromkeys(port.topic.type for port in ports if port.topic.type.startswith("heave_msgs/")))


def _message(name: str) -> str:
    text = schema_text(name).split(SEPARATOR)[0].strip()
    return f"### `{name}`\n\n```\n{text}\n```\n"


def main() -> None:
    """Print the page."""
    sys.stdout.write(page())


if __name__ == "__main__":
    main()
