"""A procedure of an acceptance test: its steps, what each does, and the criteria that it must meet."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from heave_devices.bench.set_signal import Event, WinchTest
from heave_node.criteria import Criterion

FAULTS_OF: Mapping[str, str] = {
    "mru": "wave_vessel.mru.faults",
    "depth": "cable_sim.sensors.depth.faults",
    "load_cell": "cable_sim.sensors.load_cell.faults",
    "encoder": "virtual_winch.encoder.faults",
    "winch": "virtual_winch.faults",
}
"""Parameter group of the scheduled faults of each device, by the name that a procedure gives it."""


@dataclass(frozen=True)
class RunTest:
    """The whole loop."""

    scenario: str = ""  # shipped name or file; "": that of the procedure
    settings: Mapping[str, object] = field(default_factory=dict)  # changes by place
    duration: float | None = None  # [s]; None: that of the scenario
    transient: float | None = None  # [s]; None: that of the scenario
    seed: int | None = None  # None: that of the scenario


@dataclass(frozen=True)
class Step:
    """A step."""

    name: str  # for people
    what: str  # for people
    wanted: tuple[Criterion, ...]  # criteria, all of which it must meet
    test: WinchTest | RunTest | None  # what is done; None: it can be judged on a record alone
    event: Event | None = None  # what happens during it; None: nothing
    alarms: tuple[str, ...] = ()  # codes of which one must come after the event
    window: tuple[float, float] = (0.0, math.inf)  # of a record that is judged [s] from its start

    @property
    def slug(self) -> str:
        """Name of its files."""
        return re.sub(r"\W+", "_", self.name.lower()).strip("_")


@dataclass(frozen=True)
class Procedure:
    """A procedure, read and checked."""

    path: Path  # of its file
    text: bytes  # of its file
    title: str  # for people
    scenario: str  # shipped name or file
    steps: tuple[Step, ...]  # in order
    description: str = ""  # for people
    settings: Mapping[str, object] = field(default_factory=dict)  # changes of the scenario, by place
    signatures: tuple[str, ...] = ()  # who signs
