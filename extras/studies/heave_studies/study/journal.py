"""Results of a study as they come, in a file beside its table, so that one that was ended goes on where it was."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from heave_node.parameters import ParameterError

from heave_studies.study.workers import Plain


def refuse_other(path: Path, found: Mapping[str, str], wanted: Mapping[str, str]) -> None:
    """Raise ParameterError where the results at `path` are not of the study that is to be run.

    Parameters
    ----------
    path : of the file
    found, wanted : its header, and what that should be
    """
    if any(found.get(name) != value for name, value in wanted.items()):
        raise ParameterError(
            f"{path}: holds results of another study, or of another version of the program: remove it to start "
            "again, or name another folder (--output)"
        )


class Journal:
    """Keeps results as lines of JSON, each written at once; a context manager.

    Parameters
    ----------
    path : of the file
    mark : of its study

    Attributes
    ----------
    results : found in the file, by number

    Raises ParameterError for a file of another study.
    """

    def __init__(self, path: Path, mark: Mapping[str, str]) -> None:
        self.path = path
        self.results: dict[int, Plain] = {}
        kept = self._read(mark) if path.exists() else []
        self._file = path.open("w", encoding="utf-8")
        for line in (json.dumps(mark), *kept):
            self._file.write(line + "\n")
        self._file.flush()

    def __enter__(self) -> Journal:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def _read(self, mark: Mapping[str, str]) -> list[str]:
        """Return the whole lines of results; the last one may have been cut off by what ended the study."""
        head, *lines = self.path.read_text(encoding="utf-8").split("\n")
        try:
            found = dict(json.loads(head))
        except (ValueError, TypeError):
            found = {}
        refuse_other(self.path, found, mark)
        for line in lines[:-1]:
            number, result = json.loads(line)
            self.results[number] = result
        return lines[:-1]

    def keep(self, number: int, result: Plain) -> None:
        """Keep the `result` of the job of a `number`: after this it is on the disk."""
        self._file.write(json.dumps([number, result]) + "\n")
        self._file.flush()

    def remove(self) -> None:
        """Remove the file: the table holds everything."""
        self._file.close()
        self.path.unlink()
