"""From a bag and a question to the answers."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from cable_sim_node.errors import PlantError
from heave_bags.mcap.reader import Bag
from heave_bringup.errors import CommandError
from heave_bringup.output import warn
from heave_node.parameters import ParameterError
from winch_controller_node.beliefs.beliefs import Beliefs
from winch_controller_node.model.lqr import DesignError

from heave_studies.whatif import DRAWS
from heave_studies.whatif.asked import Wish, asked_of, nominal_of
from heave_studies.whatif.fitness import check_known, check_record
from heave_studies.whatif.identify.prior import prior_of
from heave_studies.whatif.known import drawn, learn, other_plants
from heave_studies.whatif.signals.from_bag import read_record, scenario_text, write_text
from heave_studies.whatif.study import answers, recorded, same_again
from heave_studies.whatif.twin.plant import driven
from heave_studies.whatif.twin.winch import winch_under
from heave_studies.whatif.words import Result
from heave_studies.whatif.work import Show, quiet, work_in

MOST_DRAWS = 100
"""Plants that are tried for the bands at most."""


@dataclass(frozen=True)
class Question:
    """What is asked of a record."""

    law: str = ""  # of the first answer; empty: that of the record
    compare: Sequence[str] = ()  # further laws
    settings: Sequence[str] = ()  # changes, as for `--set`
    know: Sequence[str] = ()  # what is known better than the parameters say, as for `--know`
    scenario: Path | str = ""  # of the run, a file or a shipped name; empty: the one in the bag
    transient: float | None = None  # initial time that is left out [s]; None: the scenario's
    end: float | None = None  # time at which the record is cut off [s]; None: it is not
    draws: int = DRAWS  # plants that are tried for the bands
    seed: int = 1  # of these plants

    def __post_init__(self) -> None:
        """Raise ParameterError for a number that says nothing."""
        if not 0 <= self.draws <= MOST_DRAWS:
            raise ParameterError(f"--draws {self.draws}: must be from 0 to {MOST_DRAWS}")
        for name in ("seed", "transient", "end"):
            value = getattr(self, name)
            if value is not None and not value >= 0:
                raise ParameterError(f"--{name} {value:g}: must be 0 or more")


def ask(source: Path, question: Question, *, show: Show = quiet) -> Result:
    """Return what a record answers to a question.

    Parameters
    ----------
    source : the bag's folder
    question : what is asked
    show : called with what is done, and its share

    Raises CommandError where the record cannot carry an answer, ParameterError for what cannot be asked.
    """
    try:
        with tempfile.TemporaryDirectory(prefix="heave-") as scratch:
            return _asked(source, question, Path(scratch), show)
    except (DesignError, PlantError) as error:
        raise CommandError(f"{source}: {error}") from error


def _asked(source: Path, question: Question, scratch: Path, show: Show) -> Result:
    """Return what the record at `source` answers to a `question`; its scenario is written into `scratch`."""
    bag = Bag(source)
    scenario = question.scenario or write_text(scratch, scenario_text(bag))
    nominal, run = nominal_of(scenario)
    wish = Wish(scenario, question.law, question.settings, question.compare)
    asked_of(wish, winch_under(Beliefs(-1), nominal), has_adviser=True)
    prior = prior_of(nominal, question.know)
    record = read_record(bag, nominal, progress=lambda share: show("reading", share))
    notes = [*bag.notes, *map(str, bag.losses)]
    warn(notes)
    record = record if question.end is None else record.part(question.end)
    start = run.transient if question.transient is None else question.transient
    check_record(record, start, str(source))
    with work_in(os.cpu_count() or 1, show) as work:
        known = learn(record, nominal, start=start, prior=prior, work=work)
        check_known(known, str(source))
        follow = work.in_batches("draws of the plant", driven, 2 * question.draws)
        others = [drawn(known, question.seed, number, follow) for number in range(question.draws)]
        wanted = asked_of(wish, known.past.winch_parameters, has_adviser=record.has_adviser)
        found = answers(known, wanted, others, other_plants(known, question.seed), work=work)
    return Result(question.settings, notes, known, recorded(known, found), found, same_again(known, show=show))
