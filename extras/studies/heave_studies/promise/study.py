"""The draws of the promise as a study: each is a job, with the whole controller, and with parts of it switched off."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass
from datetime import datetime, timezone
from functools import partial
from pathlib import Path
from typing import Any
from unittest.mock import patch

import pandas
from heave_bringup.stored_scenario import stored_sections, stored_title
from heave_core.modes_table import ModeGuard
from heave_node.files.given_files import read_stated
from heave_node.parameters import ParameterError
from heave_node.scenario import sections_text
from winch_controller_node.adviser import hypothesis
from winch_controller_node.adviser.component import Adviser
from winch_controller_node.core.estimation import sense_design
from winch_controller_node.core.supervision import guard_checks, mode_machine, supervision_design
from winch_controller_node.core.supervision.modes import mode_design
from winch_controller_node.core.supervision.watch import encoder_reflex

from heave_studies.promise.cases import KINDS, Case, draw
from heave_studies.promise.run import run_case
from heave_studies.study.case_file import CASE, SCENARIO
from heave_studies.study.cost import COST
from heave_studies.study.workers import FAILURE, Job, Plain

NEVER = 1e9
"""Price at which no hypothesis is accepted [nats]; ratio and share that nothing reaches."""

Switch = tuple[Any, str, Any]
"""Owner and name of a part of the controller, and what stands in its place while a case is run."""


def _gives(value: Any) -> Callable[..., Any]:
    """Return a function that does nothing but give a `value`."""
    return lambda *_, **__: value


def _unpriced(*names: str) -> Switch:
    """Return the switch with which no quantity of these `names` of the judge is found."""
    return hypothesis, "PRICES", {**hypothesis.PRICES, **{getattr(hypothesis, name): NEVER for name in names}}


def _with(owner: Any, name: str, value: float) -> Switch:
    """Return the switch with which the constant of a `name` that the core gets from a module, `owner`, is a `value`."""
    return owner, "CONSTANTS", {**owner.CONSTANTS, name: value}


def _without_limit(name: str) -> Switch:
    """Return the switch with which no amplitude is too large by the guard's limit of a `name`."""
    return guard_checks, name, getattr(guard_checks, name)._replace(ratio=NEVER)


def _without_gates(*given: Any) -> dict[str, Any]:
    """Return the values of the core's ModeDesign in which no gate keeps compensation from beginning."""
    values = mode_design(*given)
    return values | {"rows": [row | {"guards": row["guards"] & ~ModeGuard.IF_GATES_OPEN} for row in values["rows"]]}


LEARNING: Mapping[str, Sequence[Switch]] = {
    "winch": [(Adviser, "_take_winch", _gives(None))],
    "encoder scale": [(Adviser, "_take_encoder", _gives(None)), _unpriced("ENCODER_SCALE")],
    "mru": [_unpriced("MRU_SCALE", "MRU_OFFSET", "MRU_DELAY", "DRIFT", "HIGH_PASS")],
    "depth scale": [_unpriced("DEPTH_SCALE")],
    "cable": [_unpriced("INERTIA", "DAMPING")],
    "exclusion": [(hypothesis, "EXCLUSION", NEVER)],
    "sea": [(Adviser, "_look_at_sea", _gives(None))],
    "all learning": [(Adviser, name, _gives(False)) for name in ("_look_at_winch", "_judge", "_look_at_sea")],
}
"""Findings of the adviser."""

NO_NOISE = sense_design.GATES | {"fewest_noise": NEVER, "noise_unknown": 1.0}
REFLEXES: Mapping[str, Sequence[Switch]] = {
    "encoder reflex": [_with(encoder_reflex, "straight", 0.0)],
    "exclusion after jumps": [(sense_design, "EXCLUDES_JUMPED", False)],
    "sensor noise": [(sense_design, "GATES", NO_NOISE)],
    "share by the sea": [_with(supervision_design, "cautious", 1.0)],
    "authority": [_with(guard_checks, "worth", NEVER)],
}
"""Reflexes of the core within a tick."""

GUARD: Mapping[str, Sequence[Switch]] = {
    "drum check": [_without_limit("DRUM")],
    "swing check": [_without_limit("SWING")],
    "depth check": [_without_limit("DEPTH")],
    "mismatch check": [_without_limit("MISMATCH")],
    "waves check": [_with(guard_checks, "full_share", NEVER)],
}
CHECKS: Mapping[str, Sequence[Switch]] = {
    "gates": [(mode_machine, "mode_design", _without_gates)],
    **GUARD,
    "guard": [switch for switches in GUARD.values() for switch in switches],
}
"""Checks of supervision."""

ALL: Mapping[str, Sequence[Switch]] = {**LEARNING, **REFLEXES, **CHECKS}
"""Everything that can be switched off, by name."""


@contextmanager
def switched_off(name: str) -> Iterator[None]:
    """Have this process run without a part of the controller, by its `name` in `ALL`, within; empty: with all."""
    with ExitStack() as stack:
        for switch in ALL[name] if name else ():
            stack.enter_context(patch.object(*switch))
        yield


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
            text = {SCENARIO: found.pop(SCENARIO, ""), "detail": alarms}
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
