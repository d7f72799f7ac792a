"""What follows a run: its bag is checked, judged and reported.

Imported only then, since plots and models take seconds to load.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from heave_bags.analyse import analysis, run_warnings, run_words
from heave_bags.analyse.verdict import Verdict, judge
from heave_bags.errors import NoBagError
from heave_bags.mcap.reader import Bag
from heave_bags.report import headline
from heave_bags.report.report import save_report
from heave_msgs.msg import TickStatus
from heave_node.criteria import Criterion

from heave_bringup.errors import CommandError
from heave_bringup.run.records import read_records
from heave_bringup.scenarios import Scenario


def check_complete(bag: Path, status: TickStatus) -> None:
    """Refuse a lockstep `bag`, its folder, that lacks a message which a node says it published, by the last `status` of
    the clock master.

    Raises CommandError, naming the first topic.
    """
    recorded = {name: topic.message_count for name, topic in Bag(bag).topics.items()}
    for topic, published in zip(status.topics, status.published, strict=True):
        if recorded.get(topic, 0) < published:  # more is not a loss: other nodes, too, publish on /diagnostics
            raise CommandError(f"{bag}: holds {recorded.get(topic, 0)} of {published} messages of {topic}")


@dataclass(frozen=True)
class Evaluation:
    """What a run gave."""

    headline: str  # the figures of merit that sum the run up, as a table
    table: str  # of all figures of merit
    figures: dict[str, object]  # the same for a machine
    errors: list[str]  # that the nodes reported, the gravest first, each in words
    losses: list[str]  # of compensation, each in words
    warnings: list[str]  # what a reader of the figures must be warned of
    verdict: Verdict  # by the criteria of the scenario and of the command line


def evaluate(
    scenario: Scenario,
    bag: Path,
    report: Path | None,
    *,
    required: Sequence[Criterion] = (),
    baseline: bool | None = False,
) -> Evaluation:
    """Evaluate a run.

    Parameters
    ----------
    scenario : of the run
    bag : folder of the bag
    report : file of the HTML report; None writes none
    required : criteria of the command line
    baseline : the scenario is run again under the baseline law, in this process; the result is kept beside the bag.
        None: where the extra for it is installed
    """
    try:
        records = read_records([bag], baseline=baseline)
    except NoBagError as error:  # of a run that was made: nothing was refused
        raise CommandError(str(error)) from error
    (record,) = records
    errors = run_words.errors(record)
    verdict = judge(record, scenario.wanted, required=required, moves_winch=scenario.moves_winch, alarms=len(errors))
    if report is not None:
        save_report(records, report, [verdict])
    losses = run_words.losses(record)
    warnings = run_warnings.warnings(record, record.kpis())
    figures = {
        **analysis.to_json(record),
        "alarms": errors,
        "losses_of_compensation": losses,
        "warnings": warnings,
        "verdict": verdict.to_json(),
    }
    return Evaluation(headline.table(records), analysis.table(records), figures, errors, losses, warnings, verdict)
