"""The table of a study as a Parquet file: a row holds all that is needed to repeat its case, files that it read too."""

from __future__ import annotations

import base64
import hashlib
import json
import os
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from heave_bringup.scenarios import NAMES_OF_FILES, write_scenario
from heave_node.files.archive import digest_in, is_plain_name, pack, unpack
from heave_node.files.given_files import whole_file
from heave_node.parameters import ParameterError
from heave_node.scenario import parse_sections, sections_text

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


FILE_MARK = b"heave_file."
"""Opens the names, with the digest of a file, under which a table's metadata holds it."""

MOST_KEPT = 16 * 2**20
"""Files of one table are kept up to so many bytes together, packed; of the largest ones beyond it the digest alone.

Each reader of the table reads its metadata whole, and Parquet readers take 100 MB at most.
"""

MOST_READ = 10 * MOST_KEPT
"""Larger ones [bytes] are not even packed to see whether they shrink enough: tables of numbers do so to a third."""

DIGITS = 12
"""Digits of a digest that are shown."""

MOST_IN_FOLDER = 10_000
"""A folder with more files is none that a case read: a bag has one for each split."""

_DIGEST = re.compile(r"[0-9a-f]{64}")


@dataclass(frozen=True)
class KeptFile:
    """A file, or a folder as a bag is one, that cases read."""

    name: str  # its own, without the folder that it lay in
    digest: str  # as `digest_of` gives it
    size: int  # of its contents [bytes]
    packed: bytes = b""  # the contents as a ZIP archive; empty where they were too large to be kept


def digest_of(path: Path) -> str:
    """Return the SHA-256 of the file at `path`; of a folder that of the lines that `sha256sum` has of its files."""
    if not path.is_dir():
        digest = hashlib.sha256()
        with path.open("rb") as file:
            while block := file.read(2**20):
                digest.update(block)
        return digest.hexdigest()
    lines = "".join(f"{digest_of(one)}  {one.relative_to(path).as_posix()}\n" for one in _files_in(path))
    return hashlib.sha256(lines.encode()).hexdigest()


def keep_files(paths: Iterable[str]) -> dict[str, KeptFile]:
    """Return the files at `paths`, by path; small ones with their contents, as many as MOST_KEPT has room for."""
    found = {path: _known(Path(path)) for path in sorted(set(paths))}
    room, packed = MOST_KEPT, {}
    for path, file in sorted(found.items(), key=lambda item: item[1].size):
        if file.digest not in packed:
            contents = _packed(Path(path)) if file.size <= MOST_READ else b""
            packed[file.digest] = contents if len(contents) <= room else b""
            room -= len(packed[file.digest])
    return {path: KeptFile(one.name, one.digest, one.size, packed[one.digest]) for path, one in found.items()}


def to_metadata(files: Iterable[KeptFile]) -> dict[bytes, bytes]:
    """Return `files` as metadata of a table, each digest once."""
    return {
        FILE_MARK + file.digest.encode(): json.dumps(
            {"name": file.name, "size": file.size, "zip": base64.b64encode(file.packed).decode()}
        ).encode()
        for file in files
    }


def from_metadata(metadata: Mapping[bytes, bytes], where: str) -> dict[str, KeptFile]:
    """Return the files that a table's `metadata` holds, by digest; anyone may have written them.

    Parameters
    ----------
    metadata : of the table
    where : opens error messages: the table

    Raises ParameterError for what is no kept file: a digest is 64 hex digits, a name that of a file in a folder.
    """
    found = {}
    for key, value in metadata.items():
        if not key.startswith(FILE_MARK):
            continue
        digest = _checked_digest(key.removeprefix(FILE_MARK).decode(errors="replace"), where)
        try:
            content = json.loads(value)
            name, size, packed = content["name"], content["size"], base64.b64decode(content["zip"], validate=True)
            is_good = is_plain_name(name) and type(size) is int and size >= 0
        except (ValueError, TypeError, LookupError, RecursionError):
            is_good = False
        if not is_good:
            raise ParameterError(f"{where}: what it keeps of the file {digest[:DIGITS]} is damaged")
        found[digest] = KeptFile(name, digest, size, packed)
    return found


def read_files(text: str, where: str) -> dict[str, str]:
    """Return the digests of the files that a case read, by path, from the `text` in its row; `where` names the case.

    Raises ParameterError for any other text.
    """
    try:
        files = json.loads(text)
    except (ValueError, RecursionError):
        files = None
    if not isinstance(files, dict):
        raise ParameterError(f"{where}: its files are no digests by path")
    return {path: _checked_digest(digest, where) for path, digest in files.items()}


def _checked_digest(digest: object, where: str) -> str:
    if not isinstance(digest, str) or not _DIGEST.fullmatch(digest):
        raise ParameterError(f"{where}: {str(digest)[:80]!r} is no digest of a file: it must be 64 hex digits")
    return digest


def make_good(
    read: Mapping[str, str], kept: Mapping[str, KeptFile], named: Collection[str], folder: Path, where: str
) -> tuple[dict[str, str], list[str]]:
    """Write what a case read and is not there any more, or not as it was; return where it is now, by path, and a line
    on each.

    Parameters
    ----------
    read : digests of the files that the case read, by path
    kept : files of its table, by digest
    named : paths that are wanted; others do not count
    folder : for the files
    where : table and case, for messages

    Raises ParameterError for a file that was too large to be kept, or that cannot be written.
    """
    anew, reported = {}, []
    for path, digest in read.items():
        if path not in named:
            continue
        if digest not in kept:
            raise ParameterError(f"{where}: its table does not hold what it says of {path}: it is damaged")
        file = kept[digest]
        found = _found(Path(path), file)
        if found == digest:
            continue
        has_changed = f"has changed since the case was run ({found[:DIGITS]}, not {digest[:DIGITS]})"
        wrong = has_changed if found else f"is not there (sha256 {digest[:DIGITS]})"
        if not file.packed:
            size = f"{file.size / 2**20:.1f} MB"
            raise ParameterError(f"{where}: {path} {wrong}, and, {size}, was too large for the table to keep it")
        anew[path] = str(_write(file, folder / digest[:DIGITS], where))
        reported.append(f"{path} {wrong}: the case reads what its table kept, {anew[path]}")
    return anew, reported


def _found(path: Path, file: KeptFile) -> str:
    """Return the digest of what is at a `path` now, or why it cannot be the `file`; "" where nothing is."""
    try:
        if not path.is_file() and not path.is_dir():
            return ""
        files = list(islice(_walk(path), MOST_IN_FOLDER))
        size = sum(one.stat().st_size for one in files)
        if size != file.size:  # not read: the table may name any file of this machine
            return f"{size} bytes"
        return digest_of(path)
    except OSError as error:
        return f"{error.strerror}"


def _write(file: KeptFile, folder: Path, where: str) -> Path:
    """Unpack a `file` into a `folder`, once its contents are those of its digest; return its path."""
    try:
        contents = unpack(file.packed, file.name, min(file.size, MOST_READ))
    except ValueError as error:
        raise ParameterError(f"{where}: {file.name} is damaged in the table: {error}") from error
    digest = digest_in(contents, file.name)
    if digest != file.digest:
        raise ParameterError(f"{where}: {file.name} is damaged in the table: sha256 {digest[:DIGITS]}")
    path = folder / file.name
    try:
        for name, content in contents.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(content)
    except OSError as error:
        raise ParameterError(f"{where}: {file.name} cannot be written to {folder}: {error}") from error
    return path.resolve()


def _known(path: Path) -> KeptFile:
    size = sum(one.stat().st_size for one in _files_in(path))
    return KeptFile(path.name, digest_of(path), size)


def _packed(path: Path) -> bytes:
    return pack({one.relative_to(path.parent): one.read_bytes() for one in _files_in(path)})


def _files_in(path: Path) -> list[Path]:
    """Return the files in a folder, or the file itself."""
    return sorted(_walk(path))


def _walk(path: Path) -> Iterator[Path]:
    return (one for one in path.rglob("*") if one.is_file()) if path.is_dir() else iter([path])


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
