"""Parameters that every node of a run shares, and what one node makes of all that it is given.

In a scenario file the section `/**` holds the parameters of the run, those of the shared system (`system.`) and the
criteria of its verdict (`wanted.`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from heave_node.criteria import WANTED, Criterion, parse_criterion
from heave_node.interface.topic import Topic
from heave_node.parameters import Given, build_given, describe, parameter
from heave_node.system_parameters import take_system
from heave_node.tick.clock_rule import Stamping, parse_clock
from heave_node.tick.time_budget import TimeBudget, budget_of

LOCKSTEP = "lockstep"
REALTIME = "realtime"


@dataclass(frozen=True)
class RunParameters:
    """What a run is, and how long its nodes wait for one another."""

    title: str = parameter("", description="Name of the lift, at the head of the report; empty: the scenario.")
    description: str = parameter("",
        description="What is lifted, where and why, below the title; empty: first line of the scenario.")  # fmt: skip
    tick_period: float = parameter(0.05, "s", 1e-3, 1.0, "Period of the control loop.")
    duration: float = parameter(600.0, "s", 0.0, 1e6, "Simulated length of the run.")
    transient: float = parameter(60.0, "s", 0.0, 1e6, "Initial part of the run, excluded from the figures of merit.")
    seed: int = parameter(1, "", 0, 2**31 - 1, "Seed of every random number in the run.")
    pacing: str = parameter(LOCKSTEP,
        description="lockstep: as fast as the machine can, repeatable; realtime: paced by the wall clock.",
        choices=(LOCKSTEP, REALTIME))  # fmt: skip
    participants: tuple[str, ...] = parameter(
        ("wave_vessel", "virtual_winch", "winch_controller", "winch_adviser", "recorder"),
        description="Nodes that take part in each tick, besides the clock master.")  # fmt: skip
    external: tuple[str, ...] = parameter((),
        description="Nodes, or single topics such as winch/load_cell, replaced by hardware or other programs. Their "
        "messages are used as they arrive; real time only.")  # fmt: skip
    foreign: tuple[str, ...] = parameter((),
        description="Nodes replaced by a program that takes part in each tick: --replace NODE=lockstep.")  # fmt: skip
    external_clocks: tuple[str, ...] = parameter((),
        description="Clock of each external node's stamps, as NODE=CLOCK: simulated (use_sim_time), own, none (stamp "
        "0: time of arrival), detect (from the first message; the default). NODE=CLOCK:S subtracts S seconds of "
        "latency.")  # fmt: skip
    autostart: bool = parameter(True, description="Configure and activate without a lifecycle manager.")
    start_timeout: float = parameter(300.0, "s", 1.0, 3600.0, "Wall time to wait for all nodes before the first tick.")
    participant_timeout: float = parameter(60.0, "s", 0.1, 3600.0,
        "Wall time for which a node may be silent, or compute one tick; then the run ends.")  # fmt: skip
    resend_period: float = 0.25  # wall time after which an unanswered tick is sent again [s]
    clock_offset_limit: float = parameter(0.1, "s", 1e-3, 1e9,
        "Real time: largest clock offset between two hosts; with a larger one the run is refused.")  # fmt: skip
    realtime_priority: int = parameter(0, "", 0, 99,
        "Real time: priority (SCHED_FIFO) of the nodes in the loop, whose memory is locked; 0: none.")  # fmt: skip
    # real time: fraction of the tick for which a node waits for inputs; then it uses the newest [-]
    in_tick_wait: float = 0.4

    time_budgets: tuple[str, ...] = parameter((),
        description="Real time: limits per node, as NODE=QUANTITY:S: period (time between ticks), age (of a tick at "
        "its answer), work (processor time per tick); all=... for every node. Above a limit, diagnostics warn.",
    )  # fmt: skip

    def __post_init__(self) -> None:
        if self.external and self.pacing != REALTIME:
            raise ValueError(
                f"external = {list(self.external)} needs pacing: realtime (`heave run --pacing realtime`), because "
                "hardware does not wait for a simulation"
            )

        if self.tick_count < 1:
            raise ValueError(f"duration = {self.duration:g} s: must be at least one tick of {self.tick_period:g} s")
        if self.realtime_priority and self.is_lockstep:
            raise ValueError(
                f"realtime_priority = {self.realtime_priority} needs pacing: realtime (`heave run --pacing realtime`)"
            )
        self.time_budget_of("")
        for node, _ in map(parse_clock, self.external_clocks):
            if node not in self.external:
                raise ValueError(f"external_clocks names {node}, which is not external: {list(self.external)}")

    def is_external(self, topic: Topic) -> bool:
        """Return whether messages of `topic` come from outside: its node, or the topic by itself, is external."""
        return topic.publisher in self.external or topic.name in self.external

    def stamping(self, topic: Topic) -> Stamping:
        """Return how the external publisher of `topic` stamps, as declared for the topic or for its node."""
        declared = dict(map(parse_clock, self.external_clocks))
        return declared.get(topic.name, declared.get(topic.publisher, Stamping()))

    def time_budget_of(self, node: str) -> TimeBudget:
        """Return the budget of time of a `node`."""
        return budget_of(node, self.time_budgets)

    @cached_property
    def tick_nanoseconds(self) -> int:
        """Tick period [ns]; time is counted in whole ticks of it."""
        return round(self.tick_period * 1e9)

    @cached_property
    def tick_count(self) -> int:
        """Number of ticks of the run."""
        return round(self.duration / self.tick_period)

    @cached_property
    def is_lockstep(self) -> bool:
        """True where nodes wait for everything they need."""
        return self.pacing == LOCKSTEP


@dataclass(frozen=True)
class NodeParameters:
    """Everything that one node was given, checked."""

    run: RunParameters  # parameters that all nodes share
    own: Any  # the node's own parameter set
    wanted: tuple[Criterion, ...]  # criteria of the run


def build_node_parameters(
    node: str, parameters_type: type[Any], given: Mapping[str, Given], *, where: str
) -> NodeParameters:
    """Sort and check what one node was given.

    Parameters
    ----------
    node : name of the node
    parameters_type : parameter set of its own parameters
    given : values by the names that the user gave: of the run, `system.`, `wanted.` and the node's own
    where : opens the message for a set that contradicts itself: file and node

    Raises ParameterError for the first value that is wrong, and for a name that is unknown.
    """
    of_run = {info.name for info in describe(RunParameters)}
    own_names = [info.name for info in describe(parameters_type)]
    run = {name: value for name, value in given.items() if name in of_run}
    wanted = {name: value for name, value in given.items() if name.startswith(WANTED)}
    rest = {name: value for name, value in given.items() if name not in run and name not in wanted}
    return NodeParameters(
        run=build_given(RunParameters, run, where=where),
        own=build_given(parameters_type, take_system(node, own_names, rest), where=where),
        wanted=tuple(parse_criterion(value) for value in wanted.values()),
    )
