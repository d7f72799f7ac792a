"""Files that the cases of a table read, kept in the table itself: a case is repeated without them."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

from heave_node.files.archive import digest_in, is_plain_name, pack, unpack
from heave_node.parameters import ParameterError

MARK = b"heave_file."
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
        MARK + file.digest.encode(): json.dumps(
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
        if not key.startswith(MARK):
            continue
        digest = _checked_digest(key.removeprefix(MARK).decode(errors="replace"), where)
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
