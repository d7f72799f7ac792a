"""Results of a campaign as they come, in a file beside its table, so that one that was ended goes on where it was."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any, TypeVar

from heave_node.parameters import ParameterError

from heave_studies.campaign.plan import Case
from heave_studies.campaign.runs import CaseResult, Task

_KEPT = [field.name for field in fields(CaseResult) if field.name != "case"]


def digest_of(tasks: Sequence[Task], version: str, files: Iterable[str] = ()) -> str:
    """Return what identifies a campaign: every value of every case, the files they read, the version of the program.

    Parameters
    ----------
    tasks : the cases, in their order
    version : of the program that computes them
    files : digests of the files that they read
    """
    digest = hashlib.sha256(version.encode())
    for task in tasks:
        digest.update(task.text.encode())
    for file in files:
        digest.update(file.encode())
    return digest.hexdigest()


def mark_of(digest: str, *, has_baseline: bool) -> dict[str, str]:
    """Return the header of a file of results: its `digest`, and whether each case `has_baseline`."""
    return {"digest": digest, "baseline": "yes" if has_baseline else "no"}


def refuse_other(path: Path, found: Mapping[str, str], wanted: Mapping[str, str]) -> None:
    """Raise ParameterError where the results at `path` are not of the campaign that is to be run.

    Parameters
    ----------
    path : of the file
    found, wanted : its header, and what that should be
    """
    if found.get("digest") != wanted["digest"]:
        raise ParameterError(
            f"{path}: holds results of another campaign, or of another version of the program: remove it to start "
            "again, or name another table"
        )
    if found.get("baseline") != wanted["baseline"]:
        begun = (
            "was begun with --no-baseline: give that option again"
            if wanted["baseline"] == "yes"
            else "was begun without --no-baseline: leave that option out"
        )
        raise ParameterError(f"{path}: {begun}, or remove the file to start again, or name another table")


def journal_path(table: Path) -> Path:
    """Return the file with the results so far of the campaign whose table will be at `table`."""
    return table.with_name(f"{table.name}.partial")


K = TypeVar("K", bound="KeptResults")


class KeptResults:
    """Keeps results as lines of JSON, each written at once; a context manager.

    Parameters
    ----------
    path : of the file
    mark : of its campaign

    Attributes
    ----------
    results : found in the file, by their `number`

    Raises ParameterError for a file of another campaign.
    """

    def __init__(self, path: Path, mark: Mapping[str, str]) -> None:
        self.path = path
        self.results: dict[int | str, Mapping[str, Any]] = {}
        kept = self._read(mark) if path.exists() else []
        self._file = path.open("w", encoding="utf-8")
        for line in (json.dumps(mark), *kept):
            self._file.write(line + "\n")
        self._file.flush()

    def __enter__(self: K) -> K:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def _read(self, mark: Mapping[str, str]) -> list[str]:
        """Return the whole lines of results; the last one may have been cut off by what ended the campaign."""
        head, *lines = self.path.read_text(encoding="utf-8").split("\n")
        try:
            found = dict(json.loads(head))
        except (ValueError, TypeError):
            found = {}
        refuse_other(self.path, found, mark)
        kept = []
        for line in lines[:-1]:
            result = json.loads(line)
            self.results[result["number"]] = result
            kept.append(line)
        return kept

    def keep(self, content: Mapping[str, object]) -> None:
        """Keep the `content` of a result, its number among it: after this it is on the disk."""
        self._file.write(json.dumps(content) + "\n")
        self._file.flush()


class Journal(KeptResults):
    """Results of the cases of a campaign; see `KeptResults`."""

    def result_of(self, case: Case) -> CaseResult | None:
        """Return the result that `case` had before; None where it has none yet."""
        found = self.results.get(case.number)
        if found is None:
            return None
        given: dict[str, Any] = {name: found[name] for name in _KEPT}
        for name in ("missed", "breaches"):
            given[name] = tuple(given[name])
        return CaseResult(case, **given)

    def add(self, result: CaseResult) -> None:
        """Keep a result: after this it is on the disk."""
        kept = {name: getattr(result, name) for name in _KEPT}
        self.keep({"number": result.case.number, **kept, "kpis": dict(result.kpis)})

    def remove(self) -> None:
        """Remove the file: the table holds everything."""
        self._file.close()
        self.path.unlink()
