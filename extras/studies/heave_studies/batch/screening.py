"""The screening of a study's cases: those that a batch of lifts covers, all seeds of a combination in one job."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from itertools import groupby

import pandas

from heave_studies.batch.lifts import Flown, LiftBatch, NotCoveredError
from heave_studies.study.cost import LOOP, START, Meter
from heave_studies.study.runs import Task, in_a_line, judge
from heave_studies.study.table import FLAG, SCREENED
from heave_studies.study.workers import FAILURE, Job, Plain

LIFTS = "lifts"
"""Key of the result of a screening: what each of its cases came to, by number, or why it belongs into the full loop."""


def screening_jobs(tasks: Sequence[Task]) -> Iterator[Job]:
    """Yield a job for the `tasks` of each combination, its number that of the first one, below 0."""
    for _, of_one in groupby(tasks, key=lambda task: repr((task.case.is_nominal, task.case.settings))):
        same = list(of_one)
        first = same[0].case
        yield Job(-first.number, f"{len(same)} seeds screened, {first.label}", partial(screen, same))


def screen(tasks: Sequence[Task]) -> Plain:
    """Return what the cases of `tasks`, which differ by their seeds alone, come to where a screening covers them."""
    first = Meter()
    with first.of(START):
        batch = _batch_of(tasks[0])
    meters = [first, *(Meter() for _ in tasks[1:])]
    lifts = {str(one.case.number): _screened(one, batch, meter) for one, meter in zip(tasks, meters, strict=True)}
    return {LIFTS: lifts}


def _batch_of(task: Task) -> LiftBatch | str:
    try:
        return LiftBatch(task.scenario)
    except Exception as error:  # what cannot be screened may run in full, and says there what is wrong
        return in_a_line(error)


def _screened(task: Task, batch: LiftBatch | str, meter: Meter) -> Plain:
    if isinstance(batch, str):
        return {FLAG: batch}
    try:
        with meter.of(LOOP):
            flown: Flown = batch.fly(task.scenario.run.seed)
    except NotCoveredError as error:
        return {FLAG: str(error)}
    if flown.flag:
        return {FLAG: flown.flag}
    return {**judge(task, flown.record, flown.strain, meter).to_plain(), "is_screened": True}


def screened_results(results: Mapping[int, Plain]) -> dict[int, Plain]:
    """Return the results by case that stand among the `results` of a study with their screenings."""
    lifts = {int(n): one for number, of in results.items() if number < 0 for n, one in of.get(LIFTS, {}).items()}
    return {number: one for number, one in lifts.items() if FAILURE in one} | {
        number: {**one, FLAG: lifts.get(number, {}).get(FLAG, "")} for number, one in results.items() if number > 0
    }


def screening_words(frame: pandas.DataFrame) -> str:
    """Return how many cases of a `frame` were screened, and why the others were not; "" where none was to be."""
    if SCREENED not in frame or not (frame[SCREENED].any() or (frame[FLAG] != "").any()):
        return ""
    number = int(frame[SCREENED].sum())
    why = frame.loc[~frame[SCREENED], FLAG].value_counts()
    reasons = ", ".join(f"{words} ({count})" for words, count in why.head(6).items())
    rest = f"; in the full loop: {reasons}" if len(why) else ""
    how = "the plant under a fixed law, without adviser, modes, gates"
    return f"{number} of {len(frame)} cases were screened: {how}{rest}"
