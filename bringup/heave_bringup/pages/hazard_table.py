"""Hazards of a heave compensator and the protective measures of the suite against each: the rows of `hazards.yaml`.

Causes are the faults of `heave_node.interface.faults`, detections the alarms of `heave_bringup.pages.alarms`, reactions
rows of the table of modes. A fault, a high or critical alarm, or a mode entered without a request that no hazard names
fails a test, and so does a test that is not there.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cable_sim_node.winch.parameters import WinchParameters
from heave_node.files.bounded_yaml import parse_yaml
from winch_controller_node.core.supervision.modes import Event
from winch_controller_node.core.supervision.supervisor import BLIND_LIMIT
from winch_controller_node.parameters.laws import ModeParameters

VALUES = {"winch": WinchParameters(), "modes": ModeParameters(), "blind_minutes": BLIND_LIMIT / 60.0}
"""What the words of a hazard may name in braces."""


@dataclass(frozen=True)
class Hazard:
    """A hazard, and the protective measures against it."""

    name: str  # the hazardous event, and whom or what it harms
    alarms: tuple[str, ...]  # codes by which it is detected; `*` stands for any letters
    reaction: str  # besides the changes of mode, in words
    time: str  # from the cause to the reaction, with its source
    residual: str  # risk that remains
    tests: tuple[str, ...]  # `file::function` of tests that show it
    causes: Mapping[str, tuple[str, ...]]  # faults by kind of device
    others: str = ""  # causes that are no fault of a simulated device, in words
    events: tuple[Event, ...] = ()  # of the table of modes, to which the controller reacts


def _hazard(row: Mapping[str, Any]) -> Hazard:
    """Return the hazard of a row of the file."""
    cells: dict[str, Any] = {
        name: cell.format(**VALUES) if isinstance(cell, str) else tuple(cell) for name, cell in row.items()
    }
    causes = {device: tuple(kinds) for device, kinds in row.get("causes", {}).items()}
    events = tuple(Event[name.upper()] for name in row.get("events", ()))
    return Hazard(**{**cells, "causes": causes, "events": events})


HAZARDS = tuple(map(_hazard, parse_yaml(Path(__file__).with_name("hazards.yaml").read_text(encoding="utf-8"))))
"""Hazards, the winch's own first."""
