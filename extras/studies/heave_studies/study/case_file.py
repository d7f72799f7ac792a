"""The table of a study as a Parquet file: a row holds all values that repeat its case."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from heave_bringup.scenarios import write_scenario
from heave_node.files.given_files import whole_file
from heave_node.parameters import ParameterError

if TYPE_CHECKING:
    import pandas

ENDING = ".parquet"
CASE, SCENARIO = "case", "scenario"
"""Columns with the number of a case, and with all its active values as a scenario file has them."""

MARK = b"heave."
"""Opens the names of what the file itself says: campaign, versions, commit."""

_REFERENCE = re.compile(rf"(.+{re.escape(ENDING)}):(\d{{1,9}})")


def write_cases(frame: pandas.DataFrame, path: Path, about: Mapping[str, str]) -> None:
    """Write the cases of a `frame` to `path`; equal cases give equal bytes, and no half of a file is ever seen.

    Parameters
    ----------
    frame : one row for each case
    path : of the file
    about : header of the file, by name

    Raises ParameterError without pyarrow.
    """
    arrow, parquet = _pyarrow(path)
    table = arrow.Table.from_pandas(frame, preserve_index=False)
    named = {MARK + name.encode(): text.encode() for name, text in about.items()}
    table = table.replace_schema_metadata({**(table.schema.metadata or {}), **named})
    with whole_file(path) as unfinished:
        parquet.write_table(table, unfinished, compression="zstd")


def read_cases(path: Path) -> tuple[pandas.DataFrame, dict[str, str]]:
    """Return the cases of the file at `path`, and its header; raise ParameterError for any other file."""
    table = _read(path)
    metadata = table.schema.metadata or {}
    about = {
        name.removeprefix(MARK).decode(errors="replace"): text.decode(errors="replace")
        for name, text in metadata.items()
        if name.startswith(MARK)
    }
    return table.to_pandas(), about


def _read(path: Path) -> Any:
    if not path.is_file():
        raise ParameterError(f"{path}: no such file")
    arrow, parquet = _pyarrow(path)
    try:
        table = parquet.read_table(path)
        table.validate(full=True)  # texts too
    except (OSError, ValueError, arrow.ArrowException) as error:
        raise ParameterError(f"{path}: cannot be read as a table of cases: {str(error).splitlines()[0]}") from error
    missing = [name for name in (CASE, SCENARIO) if name not in table.column_names]
    if missing:
        raise ParameterError(f"{path}: is not a table of heave study: it has no column {missing[0]}")
    kinds = {CASE: arrow.types.is_integer, SCENARIO: _is_text}
    other = [name for name, is_kind in kinds.items() if not is_kind(table[name].type)]
    if other:
        raise ParameterError(f"{path}: is not a table of heave study: its {other[0]} is {table[other[0]].type}")
    return table


def _is_text(kind: Any) -> bool:
    return str(kind) in ("string", "large_string")


def check_can_write(path: Path) -> None:
    """Raise ParameterError where a table could not be written to `path`, before hours go into its cases."""
    _pyarrow(path)
    if not path.parent.is_dir():
        raise ParameterError(f"{path}: there is no folder {path.parent}")


def split_reference(name: str) -> tuple[Path, int] | None:
    """Return file and case where `name` is `FILE.parquet:CASE`; None for any other name."""
    found = _REFERENCE.fullmatch(name)
    return (Path(found[1]), int(found[2])) if found else None


def case_in(path: Path, number: int) -> str:
    """Return the scenario of case `number` in the table at `path`, as the text of a scenario file.

    Raises ParameterError for a file or a case that is not there.
    """
    frame, _ = read_cases(path)
    rows = frame[frame[CASE] == number].to_dict("records")
    if not rows:
        raise ParameterError(f"{path}: has no case {number}: it has {frame[CASE].min()} to {frame[CASE].max()}")
    if not rows[0][SCENARIO]:
        raise ParameterError(f"{path}: case {number} is no run of a scenario")
    return str(rows[0][SCENARIO])


def _pyarrow(path: Path) -> tuple[Any, Any]:
    try:
        import pyarrow  # noqa: PLC0415 - slow to import, and no package of Debian that ROS could name
        import pyarrow.parquet  # noqa: PLC0415
    except ImportError as error:
        raise ParameterError(f"{path}: Parquet needs the package pyarrow: pip install pyarrow") from error
    return pyarrow, pyarrow.parquet


def write_case(reference: str, path: Path | None = None) -> Path:
    """Write the scenario of a case, and return its file.

    Parameters
    ----------
    reference : FILE.parquet:CASE
    path : of the scenario file; None: `FILE_case_CASE.yaml` in the working folder

    Raises ParameterError for what is no case.
    """
    case = split_reference(reference)
    if case is None:
        raise ParameterError(f"--case {reference}: must be FILE.parquet:CASE, for example table.parquet:17")
    path = path or Path(f"{case[0].stem}_case_{case[1]}.yaml")
    write_scenario(path, case_in(*case))
    return path


def digest_of(path: Path) -> str:
    """Return the SHA-256 of the file at `path`; of a folder that of the lines that `sha256sum` has of its files."""
    if not path.is_dir():
        digest = hashlib.sha256()
        with path.open("rb") as file:
            while block := file.read(2**20):
                digest.update(block)
        return digest.hexdigest()
    lines = "".join(f"{digest_of(one)}  {one.relative_to(path).as_posix()}\n" for one in sorted(_walk(path)))
    return hashlib.sha256(lines.encode()).hexdigest()


def _walk(path: Path) -> Iterator[Path]:
    """Yield the files in a folder, or the file itself."""
    return (one for one in path.rglob("*") if one.is_file()) if path.is_dir() else iter([path])
