"""From a bag and a question to the answers."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from cable_sim_node.errors import PlantError
from heave_bags.mcap.reader import Bag
from winch_controller_node.beliefs.beliefs import Beliefs
from winch_controller_node.model.lqr import DesignError

from heave_bringup.errors import CommandError
from heave_bringup.whatif.asked import Wish, asked_of, nominal_of
from heave_bringup.whatif.fitness import check_known, check_record
from heave_bringup.whatif.identify.prior import prior_of
from heave_bringup.whatif.known import Show, drawn, learn, other_plants, quiet
from heave_bringup.whatif.signals.from_bag import read_record, scenario_text, write_text
from heave_bringup.whatif.study import answers, recorded, same_again
from heave_bringup.whatif.twin.winch import winch_under
from heave_bringup.whatif.words import Result

DRAWS = 4
"""Plants over which each loop is closed again for the bands, where nobody says how many."""


@dataclass(frozen=True)
class Question:
    """What is asked of a record.

    Attributes
    ----------
    law : of the first answer; empty: that of the record
    compare : further laws
    settings : changes, as for `--set`
    know : what is known better than the parameters say, as for `--know`
    scenario : of the run, a file or a shipped name; empty: the one in the bag
    transient : initial time that is left out [s]; None: the scenario's
    end : time at which the record is cut off [s]; None: it is not
    draws, seed : plants that are tried for the bands
    """

    law: str = ""
    compare: Sequence[str] = ()
    settings: Sequence[str] = ()
    know: Sequence[str] = ()
    scenario: Path | str = ""
    transient: float | None = None
    end: float | None = None
    draws: int = DRAWS
    seed: int = 1


def ask(bag: Bag, question: Question, *, show: Show = quiet) -> Result:
    """Return what the record of a `bag` answers to a `question`; `show` is called with what is done, and its share.

    Raises CommandError where the record cannot carry an answer, ParameterError for what cannot be asked.
    """
    try:
        with tempfile.TemporaryDirectory(prefix="heave-") as scratch:
            return _asked(bag, question, Path(scratch), show)
    except (DesignError, PlantError) as error:
        raise CommandError(f"{bag.path}: {error}") from error


def _asked(bag: Bag, question: Question, scratch: Path, show: Show) -> Result:
    """Return what the record of a `bag` answers to a `question`; its scenario is written into `scratch`."""
    scenario, where = question.scenario or write_text(scratch, scenario_text(bag)), str(bag.path)
    nominal, run = nominal_of(scenario)
    wish = Wish(scenario, question.law, question.settings, question.compare)
    asked_of(wish, winch_under(Beliefs(-1), nominal), has_adviser=True)
    prior = prior_of(nominal, question.know)
    record = read_record(bag, nominal, progress=lambda share: show("reading", share))
    record = record if question.end is None else record.part(question.end)
    start = run.transient if question.transient is None else question.transient
    check_record(record, start, where)
    known = learn(record, nominal, start=start, prior=prior, show=show)
    check_known(known, where)
    others = [drawn(known, question.seed, number) for number in range(question.draws)]
    wanted = asked_of(wish, known.past.winch_parameters, has_adviser=record.has_adviser)
    plants = other_plants(known, question.seed)
    found = answers(known, wanted, others, plants, processes=os.cpu_count() or 1, show=show)
    return Result(known, recorded(known, found), found, same_again(known, show=show))
