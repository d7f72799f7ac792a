"""The table of a study as a Parquet file: a row holds all that is needed to repeat its case."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from heave_bringup.scenarios import NAMES_OF_FILES, write_scenario
from heave_node.files.given_files import whole_file
from heave_node.parameters import ParameterError
from heave_node.scenario import parse_sections, sections_text

from heave_studies.study.kept_files import KeptFile, from_metadata, make_good, read_bounded, read_files, to_metadata

if TYPE_CHECKING:
    import pandas


ENDING = ".parquet"
CASE, SCENARIO, FILES = "case", "scenario", "files"
"""Columns with the number of a case, with all its active values as a scenario file has them, and with the files that
these name: JSON of digests (SHA-256) by path. The files themselves are in the table's metadata, each once.
"""

MARK = b"heave."
"""Opens the names of what the file itself says: campaign, versions, commit."""

_REFERENCE = re.compile(rf"(.+{re.escape(ENDING)}):(\d{{1,9}})")


def write_cases(frame: pandas.DataFrame, path: Path, about: Mapping[str, str], files: Iterable[KeptFile] = ()) -> None:
    """Write the cases of a `frame` to `path`; equal cases give equal bytes, and no half of a file is ever seen.

    Parameters
    ----------
    frame : one row for each case
    path : of the file
    about : header of the file, by name
    files : that the cases read

    Raises ParameterError without pyarrow.
    """
    arrow, parquet = _pyarrow(path)
    table = arrow.Table.from_pandas(frame, preserve_index=False)
    named = {MARK + name.encode(): text.encode() for name, text in about.items()}
    table = table.replace_schema_metadata({**(table.schema.metadata or {}), **named, **to_metadata(files)})
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
        table = read_bounded(parquet, path)
        table.validate(full=True)  # texts too
    except (OSError, ValueError, arrow.ArrowException) as error:
        raise ParameterError(f"{path}: cannot be read as a table of cases: {str(error).splitlines()[0]}") from error
    missing = [name for name in (CASE, SCENARIO) if name not in table.column_names]
    if missing:
        raise ParameterError(f"{path}: is not a table of heave study: it has no column {missing[0]}")
    kinds = {CASE: arrow.types.is_integer, SCENARIO: arrow.types.is_string, FILES: arrow.types.is_string}
    other = [name for name, is_kind in kinds.items() if name in table.column_names and not is_kind(table[name].type)]
    if other:
        raise ParameterError(f"{path}: is not a table of heave study: its {other[0]} is {table[other[0]].type}")
    return table


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
    if not rows.iloc[0]:
        raise ParameterError(f"{path}: case {number} is no run of a scenario")
    return str(rows.iloc[0])


def files_of(path: Path, number: int) -> tuple[dict[str, str], dict[str, KeptFile]]:
    """Return the digests of the files that case `number` in the table at `path` read, by path, and all files that the
    table keeps, by digest; nothing of a table that is older than this.
    """
    table = _read(path)
    if FILES not in table.column_names:
        return {}, {}
    frame = table.select([CASE, FILES]).to_pandas()
    rows = [str(text) for text in frame.loc[frame[CASE] == number, FILES] if text]
    read = read_files(rows[0], f"{path}: case {number}") if rows else {}
    return read, from_metadata(table.schema.metadata or {}, str(path))


def _pyarrow(path: Path) -> tuple[Any, Any]:
    try:
        import pyarrow  # noqa: PLC0415 - slow to import, and no package of Debian that ROS could name
        import pyarrow.parquet  # noqa: PLC0415
    except ImportError as error:
        raise ParameterError(f"{path}: Parquet needs the package pyarrow: pip install pyarrow") from error
    return pyarrow, pyarrow.parquet


def write_case(reference: str, path: Path | None = None) -> tuple[Path, list[str]]:
    """Write the scenario of a case, and return its file and a line on each file that was made again.

    Files that are not where they were, or not as they were, are written beside it, into `NAME_files`.

    Parameters
    ----------
    reference : FILE.parquet:CASE
    path : of the scenario file; None: `FILE_case_CASE.yaml` in the working folder

    Raises ParameterError for what is no case, and for a file that was too large for the table to keep it.
    """
    case = split_reference(reference)
    if case is None:
        raise ParameterError(f"--case {reference}: must be FILE.parquet:CASE, for example table.parquet:17")
    path = path or Path(f"{case[0].stem}_case_{case[1]}.yaml")
    text = scenario_of(*case)
    sections = parse_sections(text.encode(), reference)
    values = [of for section in sections.values() for of in section.items()]
    named = [str(value) for name, value in values if name.endswith(NAMES_OF_FILES) and value]
    read, kept = files_of(*case)
    anew, reported = make_good(read, kept, named, path.with_name(f"{path.stem}_files"), reference)
    for section in sections.values():
        for name, value in section.items():
            if isinstance(value, str) and value in anew:
                section[name] = Path(os.path.relpath(anew[value], path.resolve().parent)).as_posix()
    title = "\n".join(line.lstrip("# ") for line in text.splitlines() if line.startswith("#"))
    write_scenario(path, sections_text(sections, title=title))
    return path, reported
