"""The contract of external nodes: what a replacement of a node must publish, may receive, and must keep to.

One table, from which the page `docs/contract.md` is written (`python -m heave_bringup.external.contract`) and against
which `heave check` holds a live node. Topics, types, times and message texts come from the code that runs.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass

from cable_sim_node.winch.parameters import WinchParameters
from heave_node.crane.pose import LARGEST, RATES
from heave_node.interface import sensors, topics
from heave_node.interface.topic import Topic
from heave_node.ros.participant import CATCH_UP_LIMIT
from heave_node.run_parameters import RunParameters
from wave_vessel_node.parameters import WaveVesselParameters
from winch_controller_node.beliefs.beliefs import LATENCY
from winch_controller_node.core.estimation.preview_watch import MAXIMUM_AGE, PROOF_TIME
from winch_controller_node.core.supervision.modes import WAIT
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.crane import CONFIRMED_AFTER

TICK = RunParameters().tick_period
WINCH = WinchParameters()
WATCHDOG = WINCH.command_timeout
BOOM_TIP_HEIGHT = WaveVesselParameters().boom_tip_height
MODES = WinchControllerParameters().modes
CRANE = WinchControllerParameters().crane
COAST, RESUME = MODES.coast_time, MODES.resume_time


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
    """What takes the place of one node."""

    node: str  # of the suite that is replaced
    what: str  # takes its place, in words
    publishes: tuple[Port, ...]  # topics out
    hears: tuple[Port, ...]  # topics in
    when_late: str  # what happens when its messages are late or stop
    handshake: str = ""  # how it and its fellow agree on brake and faults; "" where there is nothing to agree on
    advice: str = ""  # what the tables do not say and a newcomer would trip over


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
    (("encoder_payout", 1e4), ("encoder_payout_rate", 10.0)),
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

RELEASE = """A fault is latched. The field `release` of `winch/state` shows what the winch waits for:

| `release` | the winch waits for |
|---|---|
| 1 RELEASE_BRAKE_REQUEST | a fresh command with `brake: true`: the fault is acknowledged |
| 2 RELEASE_STANDSTILL | the drum to come to rest; keep `brake: true` |
| 3 RELEASE_COMMAND | a fresh command with `brake: false`: the fault is gone, `fault` and `release` are 0 |

A command is fresh if its `sequence` is higher than that of the last command accepted. While a fault is latched, any
other `sequence` with `brake: true` counts as fresh too, so a restarted controller may count from 1 again."""

CONTRACTS: tuple[Contract, ...] = (
    Contract(
        "winch_controller",
        "a controller",
        publishes=(COMMAND, OBSERVATIONS),
        hears=(CLOCK, MRU, HEAVE_PREVIEW, CRANE_POSE, STATE, *SENSORS_OF_SHIP, BELIEFS),
        when_late=f"Without a fresh command for {WATCHDOG:g} s the winch stops at its own deceleration and brakes."
        " Older commands are ignored.",
        handshake="The winch starts with its brake on. A fresh command with `brake: false` releases it. "
        "`sequence` starts at 1 and increases by 1. A latched fault is released as `virtual_winch` below states.",
        advice="Publish one command for each `clock` message, from the first one on, even if there is nothing to "
        "do (`brake: true`). To hold the load still, pay out as the boom tip rises: payout = heave, payout"
        " rate = heave rate. **Put the motion into `payout_rate`.** The suite's drive follows it within "
        "its limits, after `command_delay` and with lag `time_constant` (`system.winch`). It adds "
        f"`position_gain` ({WINCH.position_gain:g} 1/s by default) times the error in `payout`: with a gain"
        " of 0, `payout` alone moves nothing. Predict ahead by delay plus lag. Pull `encoder_payout` "
        "gently towards your mean, otherwise it drifts. Payout is limited to "
        f"{WINCH.payout_minimum:g} to {WINCH.payout_maximum:g} m by default.",
    ),
    Contract(
        "winch_adviser",
        "an adviser: identification of winch, cable, sensors and sea",
        publishes=(BELIEFS,),
        hears=(OBSERVATIONS,),
        when_late=f"An answer becomes active {LATENCY:g} s after the last tick of its batch. A later answer is "
        "rejected and counted. An invalid one is rejected, and the alarm names the faulty part. Without "
        "answers the controller keeps the last values, or the nominal ones, and reports it.",
        advice="`asked` is the last tick of the batch: `first`, plus the number of rows of `ticks`, minus one. "
        "Stamp the answer with the start of the last tick before it becomes active. The shortest valid answer has "
        "only `asked` and `authority: 1.0`. `heave run SCENARIO --replace winch_adviser=none` runs without an "
        "adviser.",
    ),
    Contract(
        "virtual_winch",
        "a winch drive",
        publishes=(STATE,),
        hears=(CLOCK, COMMAND, Port(topics.CABLE_STATE, 0.0, False, "tension (simulated cables only)")),
        when_late="Without a state for 0.5 s the simulated drum coasts to rest. The controller "
        f"treats the encoder as lost, predicts for {COAST:g} s, then stops the winch.",
        handshake="Start with the brake on and `encoder_payout` 0. Once released, the drive must stop by itself, "
        "brake and report `fault: 1` (FAULT_COMMAND_TIMEOUT) if there is no fresh command for "
        f"{WATCHDOG:g} s. If a set-point is not finite, stop, brake and report `fault: 2`. On `brake: true`, stop "
        f"and brake; this is not a fault.\n\n{RELEASE}\n\nThe suite's controller acknowledges `fault: 1` at once, "
        f"releases the drive {WAIT:g} s later and resumes compensation, up to three times; good compensation over some "
        "waves resets the count. Every other fault waits for an operator.",
        advice="Publish one state for each `clock` message, from the first one on, even before the first command."
        " Follow `payout_rate` within your speed and acceleration limits. If your drive has a position loop of its "
        "own, follow `payout` instead: the integral of `payout_rate`, on the scale of `encoder_payout`, at the end "
        "of the interval. Enter the lag of the loop as `system.winch.time_constant`. `mean_payout` is the working "
        "point, for display or to centre a drifting drum. `command_sequence` echoes the newest command in effect; "
        "delay is measured from it. Use NaN for `payout`, `payout_rate`, "
        "`payout_acceleration`, `tension` and `power` if unknown. The controller takes limits and lag from"
        " `system.winch`: set them to those of your drive.",
    ),
    Contract(
        "wave_vessel",
        "a motion reference unit, or a vessel with one",
        publishes=(MRU, BOOM_TIP, WAVE_COMPONENTS, HEAVE_PREVIEW, CRANE_POSE),
        hears=(CLOCK,),
        when_late=f"The controller predicts for {COAST:g} s. Then the depth sensor damps the load; "
        "compensation resumes after 1 s of good readings. On a short stiff cable or without a depth sensor "
        f"compensation fades out and the winch stops; it resumes after {RESUME:g} s of good readings. The simulated "
        "boom tip coasts to rest after 0.5 s.",
        advice="`mru` may have its own rate; stamp it with the time of the measurement. `boom_tip` moves the "
        "simulated cable: one message for each `clock` message, with `position` = (0, 0, height + heave), "
        f"height = `system.boom_tip_height` ({BOOM_TIP_HEIGHT:g} m by default), and `velocity.z` and "
        "`acceleration.z` of the heave. If you have only an MRU, fill `boom_tip` from its readings. Start at "
        "heave 0, or within 1 m of it. `vessel/heave_preview` may come from another process, such as a wave "
        "radar's, at its own rate. Law `mpc` uses the preview if `mpc.preview_time` is set and the preview has been "
        f"right for {PROOF_TIME:g} s, is at most {MAXIMUM_AGE:g} s old and covers that time. `crane/pose` "
        "may also come from another process at its own rate. Then `mru` refers to the boom tip in the reference "
        "pose (`system.crane`), and heave[devices] converts it to the present boom tip. A pose older than "
        f"{CRANE.pose_timeout:g} s is stale, and the last one is held. After a jump, poses are used again once there "
        f"has been no other jump for {CONFIRMED_AFTER:g} s.",
    ),
    Contract(
        "cable_sim",
        "the ship itself: cable, unit and their sensors",
        publishes=SENSORS_OF_SHIP,
        hears=(CLOCK,),
        when_late="A silent sensor counts as lost: the controller continues with the others. Without a depth sensor it "
        "compensates the boom-tip motion through the cable model, and refuses moves to a depth.",
        advice="The suite supplies `clock` and the start barrier (node `ship_clock`). MRU and winch are external "
        "too, and `boom_tip` is still required. No sensor reading is required: publish what the ship has. The "
        "figures of the run are computed from sensors and estimates, and are marked so. To replace one sensor of the "
        f"simulated plant, name its topic: `--replace {SENSORS_OF_SHIP[0].topic.name}=external`.",
    ),
)
CONTRACT_OF = {contract.node: contract for contract in CONTRACTS}


def page() -> str:
    """Return the whole contract as Markdown."""
    return "\n".join([INTRODUCTION, *map(_section, CONTRACTS), LOCKSTEP])


INTRODUCTION = f"""# The contract of external nodes

Generated by `python -m heave_bringup.external.contract`.

1. Start your node. It creates its publishers and waits for `clock`.
2. `heave check --replace NODE=external` acts as its counterpart and checks it against this page. A winch is braked and
   released, never moved.
3. `heave run b2_calm_300 --pacing realtime --replace NODE=external` starts all other nodes and waits for a publisher of
   each *required* topic. Restart your node for each run.

Your node needs ROS 2 and `heave_msgs`. The suite's environment has both (`.venv/bin/python my_node.py`). It has rclpy
but no rclcpp: for C++ use your own ROS, with `heave_msgs` built by colcon. `examples/` has a one-page node of each
kind. A device on a serial line, UDP or another ROS message type needs no node: use `heave adapt MAP.yaml`.

- **Units** are SI. **Signs**: positive payout lets rope out and lowers the load; heave is positive up, depth positive
  down. Frame `world`: z up, origin at still water below the mean boom tip.
- **Clock**: `clock` comes once per tick ({TICK:g} s by default). A run starts once all nodes have joined; its first
  `clock` reads one tick, not 0. A node's stamps are `simulated` (the newest `clock`, or `use_sim_time`), `own` (any
  clock; offset and drift are estimated) or `none` (stamp 0: time of arrival). The first message decides which, unless
  you state it (`--replace NODE=external:CLOCK`). Stamps that do not fit are reported as an error. Latency before the
  stamp cannot be detected: `--replace NODE=external:CLOCK:0.04` subtracts 40 ms.
- **Quality of service**: publish as reliable or best effort, volatile, depth 10; `winch/command` as reliable. The
  suite publishes as reliable and volatile, `controller/beliefs` as transient local: subscribe as you like.
- **Messages**: fields, units and signs are in [their files](../msgs/msg); `ros2 interface show` prints them.
- **Names** are relative, including `clock`, so namespaces and remapping work. `heave run --namespace NAME` puts the run
  under `/NAME`; `heave check --namespace NAME` looks there. With `use_sim_time` in a namespace, remap
  `/clock:=/NAME/clock`. Your node may have any name.
- **The system** (winch delay, lag and limits, masses) comes from the scenario. `heave params virtual_winch` lists the
  defaults, `scenario.yaml` beside each bag has the active values, and `--set system.winch.speed_limit=1` changes one.
  The suite's controller keeps the brake on for about 25 s while it estimates the sea. Figures are computed from the
  end of the transient on (120 s in the shipped scenarios).
- **Reach**: nodes on this machine need the same `ROS_DOMAIN_ID`; other machines need `--network`
  ([several hosts](guide/howto/several_hosts.md)).
- **A topic has one publisher.** A second one is reported as an error and ignored. A publisher that has stopped may
  be restarted during the run.
"""


LOCKSTEP = f"""## In lockstep, under the name of a node

A program that can wait for its inputs may take part in every tick, in lockstep or in real time:
`heave run SCENARIO --replace NODE=lockstep` starts all other nodes and waits for a node of that name at the start
barrier. If the program is deterministic, runs with equal seeds are byte-identical.

- In Python, derive from `ParticipantNode` (`examples/lockstep_controller.py`, `examples/plant.py`). An error in your
  code ends the node and the run at once; the message names file and line.

  | you write | called | what it does |
  |---|---|---|
  | `on_build()` | once, before the run | creates the component, its inputs and its outputs |
  | `on_tick(tick)` | once per tick | takes the inputs, steps the component, publishes the outputs |
  | `on_reset()` | when `simulation/reset` restarts the run | resets your state; without it a reset ends the run |
  | `on_inactive_tick(tick)` | in place of `on_tick` while the node is inactive | advances time, publishes nothing |
  | `on_left_out(tick)` | in real time, for each tick that the node skips | advances time, publishes nothing |
  | `on_exit()` | once, however the node ends | closes files and devices |

- **In real time** a late node catches up for {CATCH_UP_LIMIT:g} s, then jumps to the newest tick; the controller
  predicts across the gap. The run then reports the lost messages at its end, with exit status 1.
- **`--replace cable_sim=lockstep`**: your plant takes part like any other node, and `ship_clock` leads the ticks. Stamp
  its readings with the end of the tick: the controller reads them in the next one.
- In any other language, follow the protocol. Its topics are relative and reliable, and keep the last 200 messages;
  `_tick/roster` and `_tick/status` are transient local.
  1. Until the roster comes, publish `_tick/join` every 0.05 s: your name, `ready`, your topics, each with its
     number of peers, and your `identity`: the first 12 bytes of the GID of your publishers in hexadecimal
     digits (from `get_publishers_info_by_topic`). Messages under another identity are rejected.
  2. `_tick/roster` holds the order of all counters: entry i counts what `nodes[i]` published on `topics[i]`.
  3. `_tick/start` begins a tick: `published[i]` messages were sent before it. Wait until you have received that many on
     each topic that you read. Then wait for `_tick/done/OTHER` of this tick from each node that acts before yours, and
     for the messages that it counts. The controller acts after `wave_vessel`, the winch after `winch_controller`,
     the plant after `wave_vessel` and `virtual_winch`. A higher `epoch` starts a new run at tick 1: discard your state.
     The adviser waits for no node. The `lag` in its join states by how many ticks it may be late: in lockstep at most
     its latency less two ticks; in real time there is no bound.
  4. Do your part and publish. Then publish `_tick/done/NODE` with the number of messages published on each of your
     outputs since the start, in the order of your join. `lost` is 0, except at the end of a run in real time.
  5. If you have already answered a `_tick/start`, publish the messages of that tick and your answer again, byte for
     byte. A start with `flush` true is the last: answer it when you have all messages, then end.
  6. If you cannot continue, publish your join again with the reason in `failure`: the run ends at once.
"""


def _section(contract: Contract) -> str:
    lines = [
        f"## `{contract.node}`: {contract.what}\n",
        *_table(contract.publishes),
        "",
        f"**Reads** {_read(contract)}.",
    ]
    if contract.advice:
        lines += ["", f"**How.** {contract.advice}"]
    lines += ["", f"**When late.** {contract.when_late}"]
    if contract.handshake:
        lines += ["", f"**Brake and faults.** {contract.handshake}"]
    return "\n".join([*lines, ""])


def _table(ports: Sequence[Port]) -> list[str]:
    """Return the table of what a node publishes."""
    rows = ["|publishes|type|rate|required|meaning|", "|---|---|---|---|---|"]
    for port in ports:
        rate = f"{port.rate:g} Hz" if port.rate else "-"
        cells = (
            f"`{port.topic.name}`",
            f"`{port.topic.type}`",
            rate,
            "yes" if port.is_required else "no",
            port.meaning,
        )
        rows.append(f"|{'|'.join(cells)}|")
    return rows


def _read(contract: Contract) -> str:
    """Return what a node may read: a topic's type and meaning stand where it is published, else here."""
    published = {port.topic.name for one in CONTRACTS for port in one.publishes}
    return ", ".join(
        f"`{port.topic.name}`" + ("" if port.topic.name in published else f" (`{port.topic.type}`: {port.meaning})")
        for port in contract.hears
    )


def main() -> None:
    """Print the page."""
    sys.stdout.write(page())


if __name__ == "__main__":
    main()
