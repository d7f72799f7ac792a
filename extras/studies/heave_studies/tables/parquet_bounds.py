"""A Parquet file of somebody else is read as far as memory allows: a few bytes of it may stand for terabytes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

ROOM = 128 << 20
ROOM_PER_BYTE = 16
"""Bytes that a file may unpack to: so many, and so many for each of its own. Tables of campaigns need a third of it."""


def read_bounded(parquet: Any, path: Path) -> Any:
    """Return the table in the Parquet file at a `path`.

    Parameters
    ----------
    parquet : the module `pyarrow.parquet`
    path : of the file

    Raises ValueError for one that unpacks to more than it may, and what pyarrow raises for any other file.
    """
    room = ROOM + ROOM_PER_BYTE * path.stat().st_size
    with parquet.ParquetFile(path) as file:
        _refuse(_promised(file.metadata), room)
        texts = [field.name for field in file.schema_arrow if str(field.type) in ("string", "large_string")]
    with parquet.ParquetFile(path, read_dictionary=texts) as file:  # each text once, however often it stands there
        table = file.read()
    _refuse(sum(_dense_size(column) for column in table.columns), room)
    for index, field in enumerate(table.schema):
        if str(field.type).startswith("dictionary"):
            table = table.set_column(index, field.name, table.column(index).cast(field.type.value_type))
    return table


def _promised(metadata: Any) -> int:
    """Return how many bytes a file's columns take: as they are packed before compression, and as numbers of 8 bytes."""
    groups = [metadata.row_group(group) for group in range(metadata.num_row_groups)]
    parts = [group.column(column) for group in groups for column in range(metadata.num_columns)]
    return sum(max(part.total_uncompressed_size, 8 * part.num_values) for part in parts)


def _dense_size(column: Any) -> int:
    """Return the bytes of a column in which every text stands as often as it does."""
    from pyarrow import compute  # noqa: PLC0415 - slow to import

    size: int = column.nbytes
    if str(column.type).startswith("dictionary"):
        for part in column.chunks:
            lengths = compute.take(compute.binary_length(part.dictionary), part.indices)
            size += compute.sum(lengths.cast("int64")).as_py() or 0
    return size


def _refuse(size: int, room: int) -> None:
    if size > room:
        raise ValueError(f"it unpacks to {size / 2**20:.0f} MB, {room / 2**20:.0f} are allowed")
