"""The table of a campaign's cases as a Parquet file: a row holds all that is needed to repeat its case."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from heave_node.parameters import ParameterError

if TYPE_CHECKING:
    import pandas

ENDING = ".parquet"
CASE, SCENARIO = "case", "scenario"
"""Columns with the number of a case, and with all its values in force as a scenario file has them."""

MARK = b"heave."
"""Opens the names of what the file itself says: campaign, versions, commit."""

_REFERENCE = re.compile(rf"(.+{re.escape(ENDING)}):(\d+)")


def write_cases(frame: pandas.DataFrame, path: Path, about: Mapping[str, str]) -> None:
    """Write the cases of a `frame` to `path`; equal cases give equal bytes, and no half of a file is ever seen.

    Parameters
    ----------
    frame : one row for each case
    path : of the file
    about : what the file says of itself, by name

    Raises ParameterError without pyarrow.
    """
    arrow, parquet = _pyarrow(path)
    table = arrow.Table.from_pandas(frame, preserve_index=False)
    named = {MARK + name.encode(): text.encode() for name, text in about.items()}
    table = table.replace_schema_metadata({**(table.schema.metadata or {}), **named})
    unfinished = path.with_name(f".{path.name}.writing")
    parquet.write_table(table, unfinished, compression="zstd")
    unfinished.replace(path)


def read_cases(path: Path) -> tuple[pandas.DataFrame, dict[str, str]]:
    """Return the cases of the file at `path`, and what it says of itself; raise ParameterError for any other file."""
    if not path.is_file():
        raise ParameterError(f"{path}: no such file")
    arrow, parquet = _pyarrow(path)
    try:
        table = parquet.read_table(path)
    except (OSError, arrow.ArrowException) as error:
        raise ParameterError(f"{path}: cannot be read as a table of cases: {str(error).splitlines()[0]}") from error
    missing = [name for name in (CASE, SCENARIO) if name not in table.column_names]
    if missing:
        raise ParameterError(f"{path}: is not a table of heave campaign: it has no column {missing[0]}")
    metadata = table.schema.metadata or {}
    about = {name.removeprefix(MARK).decode(): text.decode() for name, text in metadata.items() if MARK in name[:6]}
    return table.to_pandas(), about


def check_can_write(path: Path) -> None:
    """Raise ParameterError where a table could not be written to `path`, before hours go into its cases."""
    _pyarrow(path)
    if not path.parent.is_dir():
        raise ParameterError(f"{path}: there is no folder {path.parent}")


def split_reference(name: str) -> tuple[Path, int] | None:
    """Return file and case where `name` is `FILE.parquet:CASE`; None for any other name."""
    found = _REFERENCE.fullmatch(name)
    return (Path(found[1]), int(found[2])) if found else None


def scenario_of(path: Path, number: int) -> str:
    """Return the scenario of case `number` in the table at `path`, as the text of a scenario file.

    Raises ParameterError for a file or a case that is not there.
    """
    frame, _ = read_cases(path)
    rows = frame.loc[frame[CASE] == number, SCENARIO]
    if rows.empty:
        raise ParameterError(f"{path}: has no case {number}: it has {frame[CASE].min()} to {frame[CASE].max()}")
    return str(rows.iloc[0])


def _pyarrow(path: Path) -> tuple[Any, Any]:
    try:
        import pyarrow  # noqa: PLC0415 - slow to import, and no package of Debian that ROS could name
        import pyarrow.parquet  # noqa: PLC0415
    except ImportError as error:
        raise ParameterError(f"{path}: Parquet needs the package pyarrow: pip install pyarrow") from error
    return pyarrow, pyarrow.parquet
