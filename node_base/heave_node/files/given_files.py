"""Files that a user names, or somebody else's file: how far they are read, and as what; and whole files, written."""

from __future__ import annotations

import gzip
import zlib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from heave_node.files.bounded_yaml import parse_yaml
from heave_node.files.file_kinds import refuse_other_kind
from heave_node.parameters import ParameterError

LARGEST_FILE = 128 << 20
"""Bytes of a file, unpacked: a day of motion at 20 Hz is half of it."""
_GZIP = b"\x1f\x8b"


def read_given(path: Path) -> bytes:
    """Return the content of the file at a `path`; of one that gzip has compressed, whatever its name, unpacked.

    Raises OSError where it cannot be read, and ValueError where it is no file (a pipe or a device may never end),
    larger than LARGEST_FILE, or damaged.
    """
    if path.exists() and not path.is_file():
        raise ValueError("is not a file")
    with path.open("rb") as stream:
        is_packed = stream.read(len(_GZIP)) == _GZIP
        stream.seek(0)
        try:
            content = (gzip.GzipFile(fileobj=stream) if is_packed else stream).read(LARGEST_FILE + 1)
        except (EOFError, zlib.error, gzip.BadGzipFile) as error:
            raise ValueError(f"cannot be read to its end: {error}") from error
    if len(content) > LARGEST_FILE:
        raise ValueError(f"is larger than {LARGEST_FILE >> 20} MB")
    return content


_ZIP, _ZSTD = b"PK\x03\x04", b"\x28\xb5\x2f\xfd"
_UTF_16 = (b"\xff\xfe", b"\xfe\xff")
_TEXT_CONTROLS = frozenset("\t\n\r\f\v\x1a")


class TextFileError(ValueError):
    """A file that cannot be read as text; the message names the file and says why."""


@dataclass(frozen=True)
class Text:
    """What a text file holds."""

    lines: list[str]  # without their ends
    notes: tuple[str, ...] = ()  # what a reader should know of how it was read, one line each, without the file's name


def read_text(path: Path) -> Text:
    """Read the text file at `path`.

    Raises TextFileError for a file that is missing, broken, not text, or larger than `read_given` takes; an archive or
    workbook is named.
    """
    try:
        data = read_given(path)
    except OSError as error:
        raise TextFileError(f"{path}: cannot be read to its end: {error}") from error
    except ValueError as error:
        raise TextFileError(f"{path}: {error}") from error
    if data.startswith(_ZIP):
        raise TextFileError(f"{path}: is a ZIP archive or an Excel workbook: save it as CSV (or extract it) first")
    if data.startswith(_ZSTD):
        raise TextFileError(f"{path}: is compressed by zstd: run `unzstd` on it first")
    notes = []
    whole = data.rstrip(b"\0")
    wide = _bare_utf_16(data)
    if len(data) - len(whole) > 1 and not data.startswith(_UTF_16) and not wide:
        notes.append(f"{len(data) - len(whole)} zero bytes at its end left out")
        data = whole
    text, encoding = _decoded(path, data, wide)
    if encoding:
        notes.append(f"read as {encoding}")
    wrong = next((sign for sign in text if sign < " " and sign not in _TEXT_CONTROLS), None)
    if wrong is not None:
        raise TextFileError(f"{path}: is not a text file: it holds the control character {ord(wrong):#04x}")
    return Text(text.splitlines(), tuple(notes))


def _bare_utf_16(data: bytes) -> str:
    """Return the encoding of UTF-16 without a byte order mark: every second byte of its start is 0; "": it is not."""
    start = data[:400]
    first, second = start[0::2], start[1::2]
    if len(start) < 4 or data.startswith(_UTF_16):
        return ""
    if first.count(0) == 0 and second.count(0) > 0.9 * len(second):
        return "utf-16-le"
    return "utf-16-be" if second.count(0) == 0 and first.count(0) > 0.9 * len(first) else ""


def _decoded(path: Path, data: bytes, wide: str) -> tuple[str, str]:
    """Return the text of `data`, and its encoding where that is not UTF-8; `wide` is that of `_bare_utf_16`."""
    if wide or data.startswith(_UTF_16):
        try:
            return data.decode(wide or "utf-16"), "UTF-16 without a byte order mark" if wide else "UTF-16"
        except UnicodeDecodeError as error:
            raise TextFileError(f"{path}: is not complete UTF-16 text: {error.reason}") from error
    try:
        return data.decode("utf-8-sig"), ""
    except UnicodeDecodeError:
        return data.decode("latin-1"), "Latin-1"


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Give the place to write what is to be the file at `path`; it takes that place at the end, or leaves nothing.

    A pipe or a device is written at once. Raises OSError with the name of the file where it cannot be written.
    """
    is_file = path.is_file() or not path.exists()
    final = path.resolve() if is_file else path  # of a link, what it leads to
    unfinished = final.with_name(f".writing.{final.name}") if is_file else path
    try:
        yield unfinished
        if is_file:
            unfinished.replace(final)
    except BaseException as error:
        if is_file:
            unfinished.unlink(missing_ok=True)
        if isinstance(error, OSError) and error.errno:
            error.filename = str(path)
        raise


def shipped_files(folder: Path) -> dict[str, Path]:
    """Return the files that come with the suite in a `folder`, by name."""
    return {path.stem: path for path in sorted(folder.glob("*.yaml"))}


def find_stated(name: str, folder: Path, kind: str) -> Path:
    """Return a shipped file, or else the file of the user.

    Parameters
    ----------
    name : of the shipped one, or path of a file
    folder : of the shipped ones
    kind : what such a file states, in a word

    Raises ParameterError where neither is there.
    """
    shipped = shipped_files(folder)
    path = shipped.get(name, Path(name))
    if not path.is_file():
        raise ParameterError(f"{name}: no such {kind} or file; shipped are: {', '.join(shipped)}")
    return path


def read_stated(path: Path, known: Iterable[str], needed: Iterable[str]) -> tuple[bytes, Mapping[str, Any]]:
    """Return text and content of the file at `path`, a mapping.

    Parameters
    ----------
    path : of the file
    known, needed : keys that it may have and must have

    Raises ParameterError, in one line, for what is wrong with it.
    """
    try:
        text = read_given(path)
        content = as_mapping(parse_yaml(text, only_true_and_false=True), str(path))
    except (OSError, ValueError) as error:
        raise (
            error if isinstance(error, ParameterError) else ParameterError(f"{path}: {' '.join(str(error).split())}")
        ) from error
    known = tuple(known)
    refuse_other_kind(content, known, str(path))
    refuse_keys(content, known, str(path))
    for key in needed:
        if not content.get(key):
            raise ParameterError(f"{path}: {key} is missing")
    return text, content


def scenario_of(path: Path, content: Mapping[str, Any]) -> str:
    """Return the scenario that the `content` of the file at `path` names: shipped, or a file beside it."""
    named = str(content["scenario"])
    beside = path.parent / named
    return str(beside) if beside.suffix in (".yaml", ".yml") and beside.is_file() else named


def as_mapping(value: Any, where: str) -> Mapping[str, Any]:
    """Return the `value`, a mapping; raise ParameterError, naming `where` it stands, for another one."""
    if not isinstance(value, Mapping):
        raise ParameterError(f"{where}: must be a mapping, not {value!r}")
    return value


def as_list(value: Any, where: str) -> list[Any]:
    """Return the `value`, a list; raise ParameterError, naming `where` it stands, for another one."""
    if not isinstance(value, list):
        raise ParameterError(f"{where} must be a list")
    return value


def refuse_keys(content: Mapping[str, object], known: Iterable[str], where: str) -> None:
    """Raise ParameterError, naming `where` it stands, for a key of `content` that is not `known`."""
    if unknown := sorted(str(key) for key in set(content) - set(known)):
        raise ParameterError(f"{where}: unknown key {unknown[0]}; known: {', '.join(sorted(known))}")
