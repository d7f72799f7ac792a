"""Parameters of the recorder."""

from __future__ import annotations

from dataclasses import dataclass

from heave_node.parameters import parameter

from heave_bags.mcap.bag_writer import BagPolicy
from heave_bags.mcap.writer import COMPRESSIONS, ChunkPolicy
from heave_bags.record.session import SnapshotRing

NO_COMPRESSION = "none"


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
    snapshot_size: int = parameter(256 << 20, "byte", 1 << 20, 1 << 36, "Memory for snapshots.")
    exclude: tuple[str, ...] = parameter(("/rosout", "/parameter_events", "*/transition_event"),
        description="Patterns of topics not to record. The defaults carry wall-clock times.")  # fmt: skip
    compression: str = parameter("zstd", description="Compression of chunks.", choices=("zstd", "lz4", NO_COMPRESSION))
    chunk_size: int = parameter(192 * 1024, "byte", 1024, 1 << 25, "Size at which a chunk is closed.")
    chunk_span: float = parameter(2.0, "s", 0.01, 3600.0, "Time span at which a chunk is closed.")
    split_size: int = parameter(0, "byte", 0, 1 << 50, "Size at which a new file is started; 0: never.")
    split_duration: float = parameter(0.0, "s", 0.0, 1e9, "Time after which a new file is started; 0: never.")

    def ring(self) -> SnapshotRing:
        """Return what is kept in memory for snapshots."""
        return SnapshotRing(round(self.snapshot_duration * 1e9), self.snapshot_size)

    def policy(self) -> BagPolicy:
        """Return how bags are written."""
        compression = "" if self.compression == NO_COMPRESSION else self.compression
        assert compression in COMPRESSIONS
        chunks = ChunkPolicy(size=self.chunk_size, span=round(self.chunk_span * 1e9), compression=compression)
        return BagPolicy(chunks, self.split_size, round(self.split_duration * 1e9))
