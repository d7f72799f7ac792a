"""The nodes of the suite: where each one's process and parameter set are. One definition for launching and checking."""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from heave_node.ros.transport.forked import Forked, forks
from heave_node.run_parameters import RunParameters

MASTER = "cable_sim"
RECORDER = "recorder"
ENVELOPE = "winch_envelope"
"""Takes part where it is asked for: it bounds what another controller orders."""
ADVISER = "winch_adviser"
"""May be left out, and in real time the run goes on where it has ended."""


@dataclass(frozen=True)
class NodeEntry:
    """A node of the suite."""

    name: str  # node name
    node: str  # its class, as "module:class"; the module runs it (`python -m module`)
    parameters: str  # its parameter set, as "module:class"

    @property
    def module(self) -> str:
        """Name of the module that runs the node."""
        return self.node.partition(":")[0]

    def node_type(self) -> type[Any]:
        """Return the node's class; imported only on request, since plants and controllers are heavy."""
        return _imported(self.node)

    def parameters_type(self) -> type[Any]:
        """Return the parameter set's class; imported only on request too."""
        return _imported(self.parameters)


def _imported(place: str) -> type[Any]:
    module, name = place.split(":")
    return getattr(importlib.import_module(module), name)  # type: ignore[no-any-return]


NODES: tuple[NodeEntry, ...] = (
    NodeEntry("cable_sim", "cable_sim_node.node:CableSimNode", "cable_sim_node.node_parameters:CableSimNodeParameters"),
    NodeEntry(
        "wave_vessel", "wave_vessel_node.node:WaveVesselNode", "wave_vessel_node.parameters:WaveVesselParameters"
    ),
    NodeEntry(
        "virtual_winch", "cable_sim_node.winch_node:VirtualWinchNode", "cable_sim_node.winch.parameters:WinchParameters"
    ),
    NodeEntry(
        "winch_controller",
        "winch_controller_node.node:WinchControllerNode",
        "winch_controller_node.node_parameters:WinchControllerParameters",
    ),
    NodeEntry(
        "winch_envelope",
        "winch_controller_node.envelope_node:WinchEnvelopeNode",
        "winch_controller_node.parameters.envelope_node:WinchEnvelopeParameters",
    ),
    NodeEntry(
        "winch_adviser",
        "winch_controller_node.adviser_node:WinchAdviserNode",
        "winch_controller_node.node_parameters:WinchAdviserParameters",
    ),
    NodeEntry(
        "recorder", "heave_bags.record.recorder_node:RecorderNode", "heave_bags.record.parameters:RecorderParameters"
    ),
)
SHIP_CLOCK = NodeEntry(
    "ship_clock", "heave_bringup.external.ship_clock:ShipClock", "heave_bringup.external.ship_clock:ShipClockParameters"
)
"""Leads a run in which the plant is the ship itself."""
NODE_BY_NAME = {node.name: node for node in NODES}
COMPUTE = (
    "wave_vessel_node.component",
    "cable_sim_node.component",
    "cable_sim_node.winch.component",
    "winch_controller_node.core.component",
    "winch_controller_node.adviser.component",
    "heave_bags.mcap.bag_writer",
)
"""Modules with which the nodes compute; they load no ROS."""
PROCESS_BY_NAME = {node.name: node for node in (*NODES, SHIP_CLOCK)}
"""Processes that a run may have to start."""


def nodes_to_start(run: RunParameters, foreign: Sequence[str] = ()) -> list[str]:
    """Return the nodes of a `run` that are not replaced by hardware, started by others or left out of the run.

    The `foreign` ones are those that others start.
    """
    wanted = {MASTER, *run.participants} - set(run.external) - set(foreign)
    clock = [SHIP_CLOCK.name] if MASTER in (*run.external, *foreign) else []
    return clock + [node.name for node in NODES if node.name in wanted]


@contextmanager
def node_forks(count: int) -> Iterator[list[Forked]]:
    """Load what the nodes of a run compute with, and give `count` processes in each of which a node then starts in a
    part of the time.
    """
    for module in COMPUTE:
        importlib.import_module(module)
    importlib.import_module("heave_node.numerics.compiled").load()
    with forks(count) as waiting:
        yield waiting
