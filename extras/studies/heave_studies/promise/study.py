"""The draws of the promise as a study: each is a job, with the whole controller, and without parts of it."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from datetime import datetime, timezone
from functools import partial
from pathlib import Path

import pandas
from heave_bringup.stored_scenario import stored_sections, stored_title
from heave_node.files.given_files import read_stated
from heave_node.parameters import ParameterError
from heave_node.scenario import sections_text

from heave_studies.promise.ablation import ALL, switched_off
from heave_studies.promise.cases import KINDS, Case, draw
from heave_studies.promise.run import run_case
from heave_studies.study.case_file import CASE, FILES, SCENARIO, ReadFile
from heave_studies.study.cost import COST
from heave_studies.study.workers import FAILURE, Job, Plain

KEYS = {"title", "promise", "draws", "without"}
FLAGS = {True: "yes", False: "no", None: ""}
COLUMNS = ("kind", "seed", "index", "base", "law", "without", "differs", "words")
"""Columns that say what a draw is, before those of its outcome."""


@dataclass(frozen=True)
class Promise:
    """Draws of a kind, as the engine takes them (`heave_studies.study.engine.Kind`)."""

    name: str  # of the study
    kind: str  # of the draws, a key of KINDS
    seed: int  # of the day
    indices: tuple[int, ...]  # of the draws
    without: tuple[str, ...] = ()  # parts of the controller that are switched off, one at a time
    is_local: bool = False  # draws run anywhere
    is_open: bool = False  # each draw runs
    files: Mapping[str, ReadFile] = field(default_factory=dict)  # none is read

    @property
    def identity(self) -> str:
        """What identifies its results."""
        return repr((self.kind, self.seed, self.indices, self.without))

    @property
    def size(self) -> int:
        """Number of jobs."""
        return len(self.indices) * (1 + len(self.without))

    def _runs(self) -> list[tuple[Case, str]]:
        """Return each draw with the part that it is run without, the whole controller first."""
        drawn = [draw(self.kind, self.seed, index) for index in self.indices]
        return [(case, part) for part in ("", *self.without) for case in drawn]

    def rounds(self, _: Mapping[int, Plain]) -> Iterator[list[Job]]:
        """Yield the jobs."""
        yield [
            Job(number, f"{case.words}{f', without {part}' if part else ''}", partial(_run, case, part))
            for number, (case, part) in enumerate(self._runs(), 1)
        ]

    def frame(self, results: Mapping[int, Plain]) -> pandas.DataFrame:
        """Return a row for each draw and part, from their `results`."""
        rows = []
        for number, (case, part) in enumerate(self._runs(), 1):
            found = {name: value for name, value in results[number].items() if name != COST}
            draw_of = (case.kind, case.day, case.index, case.scenario, case.law)
            what = (*draw_of, part, "; ".join(case.deviations), case.words)
            alarms = json.dumps(found.pop("alarms", []))
            texts = {name: "; ".join(value) for name, value in found.items() if isinstance(value, list | tuple)}
            text = {SCENARIO: found.pop(SCENARIO, ""), FILES: "", "detail": alarms}
            alarmed = {"alarmed": FLAGS[found.pop("is_alarmed", None)]}
            rows.append({CASE: number, **dict(zip(COLUMNS, what, strict=True)), **found, **texts, **alarmed, **text})
        return pandas.DataFrame(rows).astype({"worst": float})


def _run(case: Case, part: str) -> Plain:
    with switched_off(part):
        outcome = asdict(run_case(case))
    text = ""
    if not outcome[FAILURE] and not part:
        scenario = case.load()
        text = sections_text(stored_sections(scenario), title=stored_title(scenario))
    return {**outcome, SCENARIO: text}


def read_promise(path: Path, ask: Mapping[str, object], draws: int | None) -> Promise:
    """Return the draws that the file at `path` states; raise ParameterError, in one line, for what is wrong with it.

    Parameters
    ----------
    path : of the file
    ask : seed (None: of the day, in UTC), only (numbers of draws), without (parts, or all)
    draws : only the first of them; None: as many as the file says
    """
    _, content = read_stated(path, KEYS, ("promise", "draws"))
    kind = str(content["promise"])
    if kind not in KINDS:
        raise ParameterError(f"{path}: promise = {kind}: must be one of {', '.join(KINDS)}")
    count = _whole(content["draws"], f"{path}: draws")
    today = int(datetime.now(timezone.utc).strftime("%Y%m%d"))
    seed = today if ask["seed"] is None else _whole(ask["seed"], "ask: seed")
    only = ask["only"]
    numbers = range(min(count, draws or count)) if only is None else only if isinstance(only, list) else [only]
    without = content.get("without", []) if ask["without"] is None else ask["without"]
    parts = list(ALL) if without == "all" else without if isinstance(without, list) else [without]
    if wrong := next((part for part in parts if part not in ALL), None):
        raise ParameterError(f"{path}: without: there is no part {wrong!r}; known: {', '.join(ALL)}, or all")
    return Promise(
        str(content.get("title") or path.stem),
        kind,
        seed,
        tuple(_whole(number, "ask: only", least=0) for number in numbers),
        tuple(map(str, parts)),
    )


def _whole(given: object, where: str, least: int = 1) -> int:
    if isinstance(given, bool) or not isinstance(given, int) or given < least:
        raise ParameterError(f"{where} = {given!r}: must be a whole number, at least {least}")
    return given
