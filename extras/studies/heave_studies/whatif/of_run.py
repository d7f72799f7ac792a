"""What would have been, beside the figures of a run: computed once, kept beside its bag."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from heave_bags.analyse.kpis.reconstruction import Reconstruction
from heave_bags.analyse.kpis.sources import FREE_HEAVE
from heave_bags.analyse.run_record import ESTIMATED, RunRecord
from heave_bags.errors import BagError
from heave_bags.mcap.reader import Bag
from heave_bags.record.provenance import git_commit, versions
from heave_bags.signals import Signal
from heave_bringup.errors import CommandError
from heave_bringup.run.baseline_law import BASELINE_LAW
from heave_bringup.run.records import BASELINE, WHATIF, Request
from heave_node.files.whole_file import whole_file
from heave_node.numerics.arrays import Array
from heave_node.parameters import ParameterError

from heave_studies.whatif.answer import Figures, unit_motion
from heave_studies.whatif.known import OFF
from heave_studies.whatif.question import Question, ask
from heave_studies.whatif.words import Result, causes, headings, lines_before, rows, to_json
from heave_studies.whatif.work import Show, quiet

MOTIONS = ("unit_heave", "uncompensated_heave")
TEXTS = ("bands", "headings", "rows", "lines", "warnings", "data")
LARGEST_FILE = 1 << 27
"""A kept answer is smaller [byte]: a day of motions."""

OFFER = "--whatif reconstructs unit and uncompensated motion from the whole record, with bands; it takes minutes"
"""What a report offers where it has no more than the controller's estimate."""


def add_to_record(record: RunRecord, request: Request, show: Callable[[str, float | None], None]) -> list[str]:
    """See `heave_bringup.run.records.AddToRecord`: adds what the winch locked and the baseline law would have given."""
    laws = () if request.asks(BASELINE) is False else (BASELINE_LAW,)
    return add_reconstruction(
        record,
        request.bag,
        Question(OFF, laws, scenario=request.name, transient=request.transient),
        computes=bool(request.asks(WHATIF)),
        show=lambda words, share: show(f"{record.name}, what would have been: {words}", share),
    )


def add_reconstruction(
    record: RunRecord, bag: Path, question: Question, *, computes: bool = True, show: Show = quiet
) -> list[str]:
    """Put what would have been into the `record` of a run, and return why it cannot be: a line, or none.

    It is computed once: the answer stays in a file beside the bag, for as long as bag, question and software are the
    same.

    Parameters
    ----------
    record : of the run
    bag : folder that it was read from
    question : with OFF as its first law
    computes : where nothing is kept, it is computed; False: it is offered
    show : called with what is done, and the share of it, where there is work
    """
    source = Bag(bag)
    file, digest = kept_at(source.path), digest_of(source, question)
    found = read_kept(file, digest)
    if found is None and not computes:
        record.notes += [OFFER] if record.sources.get(FREE_HEAVE) == ESTIMATED else []
        return []
    if found is None:
        try:
            found = reconstruction(ask(source.path, question, show=show))
        except (CommandError, ParameterError, BagError, ArithmeticError, ValueError) as error:  # of any bag
            why = f"what would have been cannot be said: {' '.join(str(error).split())}"
            record.notes.append(why)
            return [why]
        with suppress(OSError):  # a folder that cannot be written: it is computed again next time
            keep(file, digest, found)
    record.take(found)
    return []


def reconstruction(result: Result) -> Reconstruction:
    """Return a `result` to a question with OFF among its laws, as a report takes it."""
    known = result.known
    by_law = {one.asked.controller.law: one.figures for one in result.answers}
    free = _banded(by_law[OFF], "unit_sigma_m")
    bands = {"uncompensated_sigma_m": free}
    if BASELINE_LAW in by_law:
        bands["baseline_efficiency"] = _banded(by_law[BASELINE_LAW], "unit_efficiency")
    bands |= {key: _banded(result.recorded, key) for key in result.recorded.bands}
    time = known.past.record.time
    return Reconstruction(
        Signal(time, known.past.plant.unit + known.set_point + known.unexplained.heave),
        Signal(time, unit_motion(known.off, known.unexplained_in(known.off.payout))),
        bands,
        headings(),
        rows(result),
        lines_before(result),
        [*result.warnings, *causes(result.answers)],
        to_json(result),
    )


def _banded(figures: Figures, key: str) -> tuple[float, float, float]:
    return (figures.values[key], *figures.bands[key])


def kept_at(bag: Path) -> Path:
    """Return the file in which the answer of a `bag` is kept."""
    bag = bag.resolve()
    return bag.with_name(f"{bag.name}.whatif.json")


def digest_of(bag: Bag, question: Question) -> str:
    """Return what identifies an answer: the `question`, the `bag`, versions and commit of the software."""
    about = [bag.size, bag.message_count, dict(bag.run), asdict(question), versions(), git_commit()]
    return hashlib.sha256(json.dumps(about, sort_keys=True, default=str).encode()).hexdigest()


def keep(file: Path, digest: str, found: Reconstruction) -> None:
    """Keep what was `found` in a `file` with its `digest`; no half of it is ever seen. Raises OSError."""
    motions = {name: [part.time.tolist(), part.value.tolist()] for name in MOTIONS for part in [getattr(found, name)]}
    content = {"digest": digest, **motions, **{name: getattr(found, name) for name in TEXTS}}
    with whole_file(file) as unfinished:
        unfinished.write_text(json.dumps(content), encoding="utf-8")


def read_kept(file: Path, digest: str) -> Reconstruction | None:
    """Return the answer kept in a `file`; None where it holds none of this `digest`, or is not whole."""
    try:
        if file.stat().st_size > LARGEST_FILE:  # anyone may have written it
            return None
        content = json.loads(file.read_text(encoding="utf-8"))
        if content["digest"] != digest:
            return None
        bands = {str(key): tuple(float(end) for end in ends) for key, ends in content["bands"].items()}
        if any(len(ends) != 3 for ends in bands.values()):
            return None
        motions: dict[str, Any] = {name: _signal(*content[name]) for name in MOTIONS}
        return Reconstruction(**motions, **{name: content[name] for name in TEXTS} | {"bands": bands})
    except (OSError, ValueError, TypeError, LookupError, AttributeError, RecursionError, MemoryError):
        return None


def _signal(time: Sequence[float], value: Sequence[float]) -> Signal:
    parts: list[Array] = [np.array(one, dtype=float) for one in (time, value)]
    if parts[0].shape != parts[1].shape or parts[0].ndim != 1:
        raise ValueError("a motion has one value at each time")
    return Signal(*parts)
