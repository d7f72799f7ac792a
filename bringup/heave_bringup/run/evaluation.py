"""What follows a run: its bag is checked, judged and reported.

Imported only then, since plots and models take seconds to load.
"""

from __future__ import annotations

from pathlib import Path

from heave_bags.analyse import analysis
from heave_bags.analyse.report import save_report
from heave_bags.mcap.reader import Bag
from heave_msgs.msg import TickStatus

from heave_bringup.errors import CommandError
from heave_bringup.run.records import read_records


def check_complete(bag: Path, status: TickStatus) -> None:
    """Refuse a lockstep bag that lacks a message which a node says it published.

    Parameters
    ----------
    bag : folder of the bag
    status : last status of the clock master, with the number of messages of each topic

    Raises CommandError, naming the first topic.
    """
    recorded = {name: topic.message_count for name, topic in Bag(bag).topics.items()}
    for topic, published in zip(status.topics, status.published, strict=True):
        if recorded.get(topic, 0) != published:
            raise CommandError(f"{bag}: holds {recorded.get(topic, 0)} of {published} messages of {topic}")


def evaluate(bag: Path, report: Path | None) -> tuple[str, dict[str, object]]:
    """Return the table of a run's figures of merit, and the same for a machine.

    Parameters
    ----------
    bag : folder of the bag
    report : file of the HTML report; None writes none
    """
    records = read_records([bag])
    if report is not None:
        save_report(records, report)
    return analysis.table(records), dict(analysis.to_json(records[0]))
