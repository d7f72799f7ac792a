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
    """The whole loop.

    Attributes
    ----------
    scenario : shipped name or file; "": that of the procedure
    settings : changes by place
    duration, transient : [s]; None: those of the scenario
    seed : None: that of the scenario
    """

    scenario: str = ""
    settings: Mapping[str, object] = field(default_factory=dict)
    duration: float | None = None
    transient: float | None = None
    seed: int | None = None


@dataclass(frozen=True)
class Event:
    """What is done to a part during a step.

    Attributes
    ----------
    device : key of FAULTS_OF
    fault : kind of fault (`heave_node.interface.faults`), COMMAND_LOSS or BRAKE
    at, duration : [s]; 0: to the end
    magnitude : of the fault
    ask : what a person does where the part is real; "": the test does it itself
    """

    device: str
    fault: str
    at: float
    duration: float = 0.0
    magnitude: float = 0.0
    ask: str = ""

    @property
    def words(self) -> str:
        """What happens, in a line."""
        return f"{self.device}: {self.fault.replace('_', ' ')} at {self.at:g} s"


@dataclass(frozen=True)
class Step:
    """A step.

    Attributes
    ----------
    name, what : for people
    wanted : criteria, all of which it must meet
    test : what is done; None: it can be judged on a record alone
    event : what happens during it; None: nothing
    alarms : codes of which one must come after the event
    window : of a record that is judged [s] from its start
    """

    name: str
    what: str
    wanted: tuple[Criterion, ...]
    test: WinchTest | RunTest | None
    event: Event | None = None
    alarms: tuple[str, ...] = ()
    window: tuple[float, float] = (0.0, math.inf)

    @property
    def slug(self) -> str:
        """Name of its files."""
        return re.sub(r"\W+", "_", self.name.lower()).strip("_")


@dataclass(frozen=True)
class Procedure:
    """A procedure, read and checked.

    Attributes
    ----------
    path, text : of its file
    title, description : for people
    scenario : shipped name or file
    settings : changes of the scenario, by place
    signatures : who signs
    steps : in order
    """

    path: Path
    text: bytes
    title: str
    scenario: str
    steps: tuple[Step, ...]
    description: str = ""
    settings: Mapping[str, object] = field(default_factory=dict)
    signatures: tuple[str, ...] = ()
