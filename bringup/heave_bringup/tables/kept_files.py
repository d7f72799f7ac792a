"""Files that the cases of a table read, kept in the table itself: a case is repeated without them."""

from __future__ import annotations

import base64
import hashlib
import io
import json
import zipfile
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

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
"""Of a digest, for people."""

_EPOCH = (1980, 1, 1, 0, 0, 0)
"""Time of every packed file: equal contents give equal bytes."""


@dataclass(frozen=True)
class KeptFile:
    """A file, or a folder as a bag is one, that cases read.

    Attributes
    ----------
    name : its own, without the folder that it lay in
    digest : as `digest_of` gives it
    size : of its contents [bytes]
    packed : the contents as a ZIP archive; empty where they were too large to be kept
    """

    name: str
    digest: str
    size: int
    packed: bytes = b""


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


def from_metadata(metadata: Mapping[bytes, bytes]) -> dict[str, KeptFile]:
    """Return the files that a table's `metadata` holds, by digest."""
    found = {}
    for key, value in metadata.items():
        if key.startswith(MARK):
            digest, content = key.removeprefix(MARK).decode(), json.loads(value)
            found[digest] = KeptFile(content["name"], digest, content["size"], base64.b64decode(content["zip"]))
    return found


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
    anew, told = {}, []
    for path, digest in read.items():
        found = digest_of(Path(path)) if Path(path).exists() else ""
        if path not in named or found == digest:
            continue
        wrong = (
            f"has changed since the case was run (sha256 {found[:DIGITS]}, not {digest[:DIGITS]})"
            if found
            else f"is not there (sha256 {digest[:DIGITS]})"
        )
        file = kept.get(digest)
        if file is None or not file.packed:
            size = f", {file.size / 2**20:.1f} MB," if file else ""
            raise ParameterError(f"{where}: {path} {wrong}, and{size} was too large for the table to keep it")
        anew[path] = str(_write(file, folder / digest[:DIGITS], where))
        told.append(f"{path} {wrong}: the case reads what its table kept, {anew[path]}")
    return anew, told


def _write(file: KeptFile, folder: Path, where: str) -> Path:
    """Unpack a `file` into a `folder`; return its path."""
    path = folder / file.name
    try:
        with zipfile.ZipFile(io.BytesIO(file.packed)) as archive:
            archive.extractall(folder)
        written = digest_of(path)
    except (OSError, zipfile.BadZipFile) as error:
        raise ParameterError(f"{where}: {file.name} cannot be written to {folder}: {error}") from error
    if written != file.digest:
        raise ParameterError(f"{where}: {file.name} is damaged in the table: sha256 {written[:DIGITS]}")
    return path.resolve()


def _known(path: Path) -> KeptFile:
    size = sum(one.stat().st_size for one in _files_in(path))
    return KeptFile(path.name, digest_of(path), size)


def _packed(path: Path) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for one in _files_in(path):
            name = zipfile.ZipInfo(one.relative_to(path.parent).as_posix(), _EPOCH)
            archive.writestr(name, one.read_bytes(), zipfile.ZIP_DEFLATED)
    return buffer.getvalue()


def _files_in(path: Path) -> list[Path]:
    """Return the files in a folder, or the file itself."""
    return sorted(one for one in path.rglob("*") if one.is_file()) if path.is_dir() else [path]
