"""What follows a run: its bag is read, judged and reported. Imported only then: plots and models take seconds to
load.
"""

from __future__ import annotations

from pathlib import Path

from heave_bags.analyse import analysis
from heave_bags.analyse.report import save_report

from heave_bringup.run.records import read_records


def judge(bag: Path, report: Path | None) -> tuple[str, dict[str, object]]:
    """Return the table of a run's figures of merit, and the same for a machine; write the report where one is
    wanted.
    """
    records = read_records([bag])
    if report is not None:
        save_report(records, report)
    return analysis.table(records), dict(analysis.to_json(records[0]))
