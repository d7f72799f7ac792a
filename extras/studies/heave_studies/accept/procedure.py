"""A procedure of an acceptance test: its steps, what each does, and the criteria that it must meet."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from heave_node.criteria import Criterion

from heave_studies.accept.set_signal import SetSignal

FAULTS_OF: Mapping[str, str] = {
    "mru": "wave_vessel.mru.faults",
    "depth": "cable_sim.sensors.depth.faults",
    "load_cell": "cable_sim.sensors.load_cell.faults",
    "encoder": "virtual_winch.encoder.faults",
    "winch": "virtual_winch.faults",
}
"""Parameter group of the scheduled faults of each device, by the name that a procedure gives it."""
COMMAND_LOSS, BRAKE = "command_loss", "brake"
"""Events that the test does itself, to a virtual and to a real winch: it sends nothing more, or requests the brake."""


@dataclass(frozen=True)
class WinchTest:
    """A winch by itself: the `signal` that it is ordered to follow, under a `load` [N]."""

    signal: SetSignal
    load: float = 0.0


@dataclass(frozen=True)
class RunTest:
    """The whole loop."""

    scenario: str = ""  # shipped name or file; "": that of the procedure
    settings: Mapping[str, object] = field(default_factory=dict)  # changes by place
    duration: float | None = None  # [s]; None: that of the scenario
    transient: float | None = None  # [s]; None: that of the scenario
    seed: int | None = None  # None: that of the scenario


@dataclass(frozen=True)
class Event:
    """What is done to a part during a step."""

    device: str  # key of FAULTS_OF
    fault: str  # kind of fault (`heave_node.interface.faults`), COMMAND_LOSS or BRAKE
    at: float  # [s]
    duration: float = 0.0  # [s]; 0: to the end
    magnitude: float = 0.0  # in the unit of its kind
    ask: str = ""  # what a person does where the part is real; "": the test does it itself

    @property
    def words(self) -> str:
        """What happens, in a line."""
        return f"{self.device}: {self.fault.replace('_', ' ')} at {self.at:g} s"


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
