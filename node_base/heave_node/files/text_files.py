"""Text files of all makes: UTF-8 with or without byte order mark, UTF-16, Latin-1; plain or compressed by gzip."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from heave_node.files.given_files import read_given

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
