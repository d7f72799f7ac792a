"""What commands print: text and tables for people, or JSON and nothing else on standard output for machines."""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
import tempfile
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from errno import EISDIR
from pathlib import Path

from heave_node.files.given_files import whole_file
from heave_node.parameters import ParameterError
from rich import box
from rich.console import Console
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from heave_bringup.errors import CommandError

LONGEST_WORD = 24
"""Letters of a word that a table keeps in one line."""
FILE_WIDTH = 1000
"""Columns of an output that is not a terminal: nothing is wrapped there."""


@dataclass(frozen=True)
class FittedTable:
    """A table that leaves out what a terminal has no room for, and says so."""

    columns: Sequence[str]  # as `make_table` takes them
    rows: Sequence[Sequence[str]]  # as `make_table` takes them
    texts: Collection[str] = ()  # as `make_table` takes them
    optional: Sequence[str] = ()  # columns that may be left out, the last one first
    elsewhere: str = ""  # where they are then, in words

    def fitted(self, console: Console) -> list[str | Table]:
        """Return the table as wide as the `console`, and a line with what is not in it."""
        unlimited = console.options.update(max_width=FILE_WIDTH)
        for count in range(len(self.optional), -1, -1):
            missing = self.optional[count:]
            kept = [number for number, name in enumerate(self.columns) if name not in missing]
            rows = [[row[number] for number in kept] for row in self.rows]
            found = make_table([self.columns[number] for number in kept], rows, texts=self.texts)
            if Measurement.get(console, unlimited, found).minimum <= console.width:
                break
        return [found, f"not shown for want of room: {', '.join(missing)}; {self.elsewhere}"] if missing else [found]


Part = str | Table | FittedTable


def write_result(options: argparse.Namespace, parts: Part | Sequence[Part], result: object) -> None:
    """Print the result of a command.

    Parameters
    ----------
    options : of the command line; `json` says where JSON goes
    parts : text and tables for people; left out where standard output belongs to the JSON
    result : for machines: anything that JSON can hold; NaN and infinity become null

    Raises CommandError where the JSON file cannot be written.
    """
    document = json.dumps(_finite(result), indent=2) + "\n" if options.json else ""
    if options.json == "-":
        sys.stdout.write(document)
        return
    print_parts([parts] if isinstance(parts, str | Table | FittedTable) else parts)
    if options.json:
        try:
            with whole_file(Path(options.json)) as unfinished:
                unfinished.write_text(document, encoding="utf-8")
        except OSError as error:
            raise CommandError(f"{options.json}: cannot be written: {error.strerror}") from error


def warn(lines: Iterable[str]) -> None:
    """Write warnings to standard error, one for each of the `lines`."""
    sys.stderr.write("".join(f"heave: warning: {line}\n" for line in lines))


def print_parts(parts: Iterable[Part]) -> None:
    """Print `parts`, an empty line between them: text as it is, tables fitted to the terminal, no number shortened."""
    console = Console(file=sys.stdout, width=None if sys.stdout.isatty() else FILE_WIDTH)
    terminal = console.width
    pieces = [piece for part in parts for piece in (part.fitted(console) if isinstance(part, FittedTable) else [part])]
    for number, part in enumerate(pieces):
        if number:
            sys.stdout.write("\n")
        if isinstance(part, str):
            sys.stdout.write(part if part.endswith("\n") else part + "\n")
            continue
        unlimited = console.options.update(max_width=FILE_WIDTH)
        console.width = max(terminal, Measurement.get(console, unlimited, part).minimum)
        with console.capture() as capture:
            console.print(part)
        sys.stdout.write("".join(f"{line.rstrip()}\n" for line in capture.get().splitlines()))


def make_table(columns: Sequence[str], rows: Iterable[Sequence[str]], *, texts: Collection[str] = ()) -> Table:
    """Return a table for people with headings of its `columns`, units among them, and `rows` of cells as text.

    The first column and those named in `texts` hold text; the others hold numbers and align to the right.
    """
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False)
    cells = [[Text(cell) for cell in row] for row in rows]
    for number, heading in enumerate(columns):
        is_text = heading in (columns[0], *texts)
        needed = max(map(len, heading.split()))
        if is_text:
            words = (len(word) for row in cells for word in row[number].plain.split())
            needed = max(needed, min(max(words, default=0), LONGEST_WORD))
        else:
            needed = max([needed, *(row[number].cell_len for row in cells)])
        table.add_column(Text(heading), justify="left" if is_text else "right", min_width=needed)
    for row in cells:
        table.add_row(*row)
    return table


def check_output(option: str, path: Path | None, endings: Sequence[str] = (), *, makes_folder: bool = False) -> None:
    """Refuse an output file that could not be written, before the work for it begins.

    Parameters
    ----------
    option : of the command line, named in the message
    path : the file; None: no file
    endings : of file names that the command can write; none: all
    makes_folder : whether the command makes the folder of the file

    Raises ParameterError for another ending, and for a folder or a file that does not exist or cannot be written.
    """
    if path is None:
        return
    if endings and path.suffix.lower() not in endings:
        raise ParameterError(f"{option} {path}: must end in {' or '.join(endings)}")
    if not makes_folder and not path.resolve().parent.is_dir():
        raise ParameterError(f"{option} {path}: there is no folder {path.parent}")
    folder = next(one for one in path.resolve().parents if one.is_dir())
    try:
        if path.is_file():
            path.open("ab").close()
        elif path.is_dir():
            raise IsADirectoryError(EISDIR, os.strerror(EISDIR))
        elif not path.exists():  # neither a pipe nor a device
            tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        raise ParameterError(f"{option} {path}: cannot be written: {error.strerror}") from error


def _finite(value: object) -> object:
    """Return the value with every NaN and infinity as None: JSON knows neither."""
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, Mapping):
        return {str(key): _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return value
