"""Parameters of the recorder."""

from __future__ import annotations

from dataclasses import dataclass

from heave_node.parameters import parameter

from heave_bags.mcap.bag_writer import BagPolicy
from heave_bags.record.session import SnapshotRing

MOST_KEPT = 256 << 20
"""Bytes that are kept in memory for snapshots."""


@dataclass(frozen=True)
class RecorderParameters:
    """Where and how the recorder writes."""

    directory: str = parameter("bag", description="Folder of the bag; it must not exist yet.")
    scenario: str = parameter("", description="Name of the scenario, for the bag's metadata.")
    scenario_file: str = parameter("", description="Parameter file of the run, carried in the bag.")
    replaced: tuple[str, ...] = parameter((),
        description="Nodes replaced by a bag (NODE=bag) or another program, for the bag's metadata.")  # fmt: skip
    record: bool = parameter(True, description="Start recording at once; false waits for the service start.")
    snapshot_duration: float = parameter(0.0, "s", 0.0, 86400.0, "Time span kept in memory for snapshots; 0: none.")
    exclude: tuple[str, ...] = parameter(("/rosout", "/parameter_events", "*/transition_event"),
        description="Patterns of topics not to record. The defaults carry wall-clock times.")  # fmt: skip
    split_size: int = parameter(0, "byte", 0, 1 << 50, "Size at which a new file is started; 0: never.")
    split_duration: float = parameter(0.0, "s", 0.0, 1e9, "Time after which a new file is started; 0: never.")

    def ring(self) -> SnapshotRing:
        """Return what is kept in memory for snapshots."""
        return SnapshotRing(round(self.snapshot_duration * 1e9), MOST_KEPT)

    def policy(self) -> BagPolicy:
        """Return how bags are written."""
        return BagPolicy(max_file_bytes=self.split_size, max_file_span=round(self.split_duration * 1e9))
