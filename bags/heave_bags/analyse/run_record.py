"""A run as its bag records it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from heave_node.criteria import Criterion

from heave_bags.analyse import events, kpi_set
from heave_bags.analyse.events import Interval
from heave_bags.analyse.kpi_set import FREE_HEAVE, SOURCES, TIP_HEAVE, TOP_TENSION, UNIT_HEAVE
from heave_bags.analyse.reading.innovations import Innovation
from heave_bags.analyse.reading.stored import NodeParameters
from heave_bags.mcap.loss import Loss, remarks
from heave_bags.signals import RunSignals

ESTIMATED, MEASURED, TRUE = SOURCES
"""Sources of a figure: the controller's estimate, hindsight over the record, a sensor, what only a simulator knows."""


BAG = "bag"
"""What takes the place of a node that is played from a bag."""
SEA = "wave_vessel"
"""Node that makes the sea."""


def replaced_nodes(entries: Iterable[str]) -> dict[str, str]:
    """Return what took part in the place of which node, BAG or "" for another program, by `entries` NODE=bag or NODE of
    a bag's metadata.
    """
    parts = (entry.partition("=") for entry in entries)
    return {node: kind for node, _, kind in parts}


def sea_source(replaced: Mapping[str, str], seed: object) -> str:
    """Return which sea a run has in words: its `seed`, or where it comes from if its node is `replaced`."""
    if SEA not in replaced:
        return f"seed {seed}"
    return "from a bag" if replaced[SEA] == BAG else f"from another {SEA}"


@dataclass
class RunRecord:
    """A run as its bag records it."""

    name: str  # of the bag
    signals: RunSignals  # what the KPIs are computed from
    start: float  # of the evaluation window [s]: after the transient
    end: float  # of the evaluation window [s]: the end of the run
    modes: list[Interval] = field(default_factory=list)  # what held when
    alarms: list[Interval] = field(default_factory=list)  # what held when
    limits: list[Interval] = field(default_factory=list)  # what held when
    waits: list[Interval] = field(default_factory=list)  # when the controller did not compensate, and why
    requests: list[Interval] = field(default_factory=list)  # what an operator asked for, and when: factor, speed, depth
    innovations: list[Innovation] = field(default_factory=list)  # per measurement of the estimator
    run: Mapping[str, str] = field(default_factory=dict)  # the bag's own words on the run
    outcome: Mapping[str, str] = field(default_factory=dict)  # the bag's own words on the run
    losses: list[Loss] = field(default_factory=list)  # what of the bag could not be read
    notes: list[str] = field(default_factory=list)  # what a reader of the figures must know
    # where each motion comes from: TRUE, MEASURED or ESTIMATED
    sources: dict[str, str] = field(default_factory=dict)
    # of the run's nodes, as far as they are known: node -> dotted name -> value
    parameters: NodeParameters = field(default_factory=dict)
    wanted: tuple[Criterion, ...] = ()  # criteria of the scenario that the bag carries
    # histograms of durations in wall time by name, real time only: upper edge [ms] -> count
    timings: dict[str, dict[str, int]] = field(default_factory=dict)
    is_past_transient: bool = True  # the run went on after its transient; False: the figures are of its start-up
    largest_strain: float = math.nan  # of the cable in the whole run, as the plant reported it [-]; NaN: it did not
    sea: str = ""  # that its node stated, in words; "": not recorded
    title: str = ""  # of the lift, as the scenario states them; "": it does not
    description: str = ""  # of the lift, as the scenario states them; "": it does not

    @property
    def moves_winch(self) -> bool:
        """Whether the run had a law that moves the winch, as far as the bag says."""
        law = self.parameters.get("winch_controller", {}).get("law")
        by_modes = any(mode.name != events.OFF for mode in self.modes)
        return bool(law != events.OFF) if isinstance(law, str) else by_modes

    @property
    def judged_time(self) -> float:
        """How long the run went on after its transient [s]."""
        return self.end - self.start if self.is_past_transient else 0.0

    @property
    def played(self) -> list[str]:
        """Nodes in whose place a bag was played, as far as the bag says."""
        return [node for node, kind in self.replaced.items() if kind == BAG]

    @property
    def replaced(self) -> dict[str, str]:
        """What took part in the place of which node, as far as the bag says; see `replaced_nodes`."""
        return replaced_nodes(self.run.get("replaced", "").split())

    @property
    def sea_run(self) -> str:
        """Which sea was run, in words: its seed, or where it comes from; "": unknown."""
        if SEA not in self.replaced and "seed" not in self.run:
            return ""
        source = sea_source(self.replaced, self.run.get("seed"))
        return f"{source}: {self.sea}" if self.sea and SEA in self.replaced else source

    def source_notes(self) -> list[str]:
        """Return which motions are not the truth, as on a ship, where it is unknown."""
        known = [(name, self.sources.get(name, TRUE)) for name in (UNIT_HEAVE, FREE_HEAVE, TIP_HEAVE, TOP_TENSION)]
        other = [f"{name} is {source}" for name, source in known if source != TRUE]
        return [f"the true values were not recorded:  {', '.join(other)}"] if other else []

    def remarks(self) -> list[str]:
        """Return what a reader of the figures must know: the notes, and what of the bag could not be read."""
        return remarks(self.notes, self.losses)

    def kpis(self, start: float | None = None, end: float | None = None) -> dict[str, float]:
        """Return every KPI over the evaluation window, or over start..end [s]."""
        if start is None and end is None:
            return kpi_set.evaluate_run(self.signals, self.start, self.end)
        return kpi_set.evaluate(self.signals, self.start if start is None else start, self.end if end is None else end)
