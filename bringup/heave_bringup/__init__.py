"""Scenarios, launching, and the `heave` command.

Importing this package loads nothing else: a name of its face is loaded on first use.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from heave_node.faces import lazy_face

if TYPE_CHECKING:
    from heave_bringup.closed_loop import ClosedLoop, loop_parameters
    from heave_bringup.errors import CommandError
    from heave_bringup.scenarios import Scenario, load_scenario, make_scenario, shipped_scenarios

__all__ = [
    "ClosedLoop",
    "CommandError",
    "Scenario",
    "load_scenario",
    "loop_parameters",
    "make_scenario",
    "shipped_scenarios",
]
__getattr__, __dir__ = lazy_face(
    __name__,
    {
        "ClosedLoop": "closed_loop",
        "CommandError": "errors",
        "Scenario": "scenarios",
        "load_scenario": "scenarios",
        "loop_parameters": "closed_loop",
        "make_scenario": "scenarios",
        "shipped_scenarios": "scenarios",
    },
)
