"""The table of a study as a Parquet file: a row holds all values that repeat its case, and digests of its files."""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from heave_bringup.scenarios import NAMES_OF_FILES, write_scenario
from heave_node.files.given_files import whole_file
from heave_node.parameters import ParameterError
from heave_node.scenario import parse_sections, sections_text

if TYPE_CHECKING:
    import pandas

ENDING = ".parquet"
CASE, SCENARIO, FILES = "case", "scenario", "files"
"""Columns with the number of a case, with all its active values as a scenario file has them, and with the files that
these name: JSON of SHA-256 and size by path.
"""

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
    kinds = {CASE: arrow.types.is_integer, SCENARIO: _is_text, FILES: _is_text}
    other = [name for name, is_kind in kinds.items() if name in table.column_names and not is_kind(table[name].type)]
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


def case_in(path: Path, number: int) -> tuple[str, list[ReadFile]]:
    """Return the scenario of case `number` in the table at `path`, as the text of a scenario file, and what it read.

    Raises ParameterError for a file or a case that is not there.
    """
    frame, _ = read_cases(path)
    rows = frame[frame[CASE] == number].to_dict("records")
    if not rows:
        raise ParameterError(f"{path}: has no case {number}: it has {frame[CASE].min()} to {frame[CASE].max()}")
    if not rows[0][SCENARIO]:
        raise ParameterError(f"{path}: case {number} is no run of a scenario")
    return str(rows[0][SCENARIO]), from_text(str(rows[0].get(FILES) or ""), f"{path}: case {number}")


def _pyarrow(path: Path) -> tuple[Any, Any]:
    try:
        import pyarrow  # noqa: PLC0415 - slow to import, and no package of Debian that ROS could name
        import pyarrow.parquet  # noqa: PLC0415
    except ImportError as error:
        raise ParameterError(f"{path}: Parquet needs the package pyarrow: pip install pyarrow") from error
    return pyarrow, pyarrow.parquet


def write_case(reference: str, path: Path | None = None) -> tuple[Path, list[str]]:
    """Write the scenario of a case, and return its file and a line on each file that is not as it was.

    The scenario then names the copy beside the table.

    Parameters
    ----------
    reference : FILE.parquet:CASE
    path : of the scenario file; None: `FILE_case_CASE.yaml` in the working folder

    Raises ParameterError for what is no case, and for a file of which there is no copy.
    """
    case = split_reference(reference)
    if case is None:
        raise ParameterError(f"--case {reference}: must be FILE.parquet:CASE, for example table.parquet:17")
    path = path or Path(f"{case[0].stem}_case_{case[1]}.yaml")
    text, files = case_in(*case)
    sections = parse_sections(text.encode(), reference)
    named = {str(value) for section in sections.values() for name, value in section.items()
             if name.endswith(NAMES_OF_FILES) and value}  # fmt: skip
    copies, reported = {}, []
    for file in files:
        wrong = file.state() if str(file.path) in named else ""
        if not wrong:
            continue
        copy = replace(file, path=file.kept_in(case[0].parent))
        if copy.state():
            raise ParameterError(f"{reference}: {file.path} {wrong}, and there is no copy of it: {copy.path}")
        copies[str(file.path)] = os.path.relpath(copy.path.resolve(), path.resolve().parent)
        reported.append(f"{file.path} {wrong}: the case reads its copy, {copy.path}")
    for section in sections.values():
        for name, value in section.items():
            if isinstance(value, str) and value in copies:
                section[name] = Path(copies[value]).as_posix()
    title = "\n".join(line.lstrip("# ") for line in text.splitlines() if line.startswith("#"))
    write_scenario(path, sections_text(sections, title=title))
    return path, reported


KEPT = "files"
"""Folder beside the table with copies of the files that its cases read, each in one of its own by its digest."""

MOST_KEPT = 2**30
"""Larger files [bytes] are not copied: their digest alone is known."""

DIGITS = 12
"""Digits of a digest that are shown, and that name the folder of a copy."""

MOST_IN_FOLDER = 10_000
"""A folder with more files is none that a case read: a bag has one for each split."""

_DIGEST = re.compile(r"[0-9a-f]{64}")


@dataclass(frozen=True)
class ReadFile:
    """A file, or a folder as a bag is one, that cases read."""

    path: Path  # where it was
    digest: str  # as `digest_of` gives it
    size: int  # of its contents [bytes]

    def kept_in(self, folder: Path) -> Path:
        """Return where its copy is beside a table in a `folder`."""
        return folder / KEPT / self.digest[:DIGITS] / self.path.name

    def state(self) -> str:
        """Return "" where it is as it was, or else what is wrong with it, in words."""
        try:
            if not self.path.is_file() and not self.path.is_dir():
                return f"is not there (sha256 {self.digest[:DIGITS]})"
            # read only where it may be the same: the table may name any file of this machine
            size = sum(one.stat().st_size for one in islice(_walk(self.path), MOST_IN_FOLDER))
            found = digest_of(self.path)[:DIGITS] if size == self.size else f"{size} bytes"
        except OSError as error:
            found = f"{error.strerror}"
        same = found == self.digest[:DIGITS]
        return "" if same else f"has changed since the case was run ({found}, not {self.digest[:DIGITS]})"


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


def read_files(paths: Iterable[str]) -> dict[str, ReadFile]:
    """Return the files at `paths`, by path."""
    return {
        name: ReadFile(Path(name), digest_of(Path(name)), sum(one.stat().st_size for one in _walk(Path(name))))
        for name in sorted(set(paths))
    }


def keep_files(files: Iterable[ReadFile], folder: Path) -> None:
    """Copy `files` beside a table in a `folder`."""
    for file in files:
        copy = file.kept_in(folder)
        if copy.exists() or file.size > MOST_KEPT:
            continue
        copy.parent.mkdir(parents=True, exist_ok=True)
        if file.path.is_dir():
            shutil.copytree(file.path, copy)
        else:
            shutil.copyfile(file.path, copy)


def to_text(files: Iterable[ReadFile]) -> str:
    """Return the `files` of a case as its row holds them; "" where there are none."""
    found = {str(file.path): {"sha256": file.digest, "bytes": file.size} for file in files}
    return json.dumps(found) if found else ""


def from_text(text: str, where: str) -> list[ReadFile]:
    """Return the files that a case read from the `text` in its row; `where` opens the message of a ParameterError."""
    if not text:
        return []
    try:
        files = [ReadFile(Path(path), one["sha256"], one["bytes"]) for path, one in json.loads(text).items()]
        is_good = all(_DIGEST.fullmatch(one.digest) and type(one.size) is int for one in files)
    except (ValueError, TypeError, LookupError, AttributeError, RecursionError):
        is_good = False
    if not is_good:
        raise ParameterError(f"{where}: its files are damaged: each must have a path, a SHA-256 and a size")
    return files


def _walk(path: Path) -> Iterator[Path]:
    """Yield the files in a folder, or the file itself."""
    return (one for one in path.rglob("*") if one.is_file()) if path.is_dir() else iter([path])
