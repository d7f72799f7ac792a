"""Bags as the commands judge them: read, with what extras add to the record of each."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from heave_bags.analyse import analysis
from heave_bags.analyse.run_record import RunRecord
from heave_node.extras import MissingExtraError, known_parts, load_part

from heave_bringup.errors import CommandError
from heave_bringup.output import warn
from heave_bringup.progress import ProgressLine
from heave_bringup.scenarios import Scenario, load_scenario
from heave_bringup.stored_scenario import parameters_of

RECORD_EXTRAS = "heave.record_extras"
"""Group of entry points that add to the record of a run: functions as `AddToRecord`."""
BASELINE, KAPPA = "baseline", "kappa"


@dataclass(frozen=True)
class Request:
    """What is asked beside the figures of a bag."""

    bag: Path  # folder or file
    name: str = ""  # of the scenario that the command line gives; "": the bag's own
    scenario: Scenario | None = None  # the same, read
    transient: float | None = None  # start of the evaluation window [s]; None takes what the bag says
    # what is asked of each extra: True all that it has, None what costs no time, False nothing
    parts: Mapping[str, bool | None] | None = None

    def asks(self, part: str) -> bool | None:
        """Return what is asked of a `part`."""
        return (self.parts or {}).get(part)


AddToRecord = Callable[[RunRecord, Request, Callable[[str, "float | None"], None]], Sequence[str]]
"""Adds to the record of a run what is asked, showing words and share done; returns why it cannot, in lines."""


def read_records(
    bags: Sequence[Path],
    *,
    scenario: str | None = None,
    transient: float | None = None,
    baseline: bool | None = False,
) -> list[RunRecord]:
    """Read bags, showing progress.

    Parameters
    ----------
    bags : folders or files
    scenario : shipped name or file, for bags that do not carry the scenario of their run
    transient : start of the evaluation window [s]; None takes what each bag says, or else the scenario
    baseline : each run is made again under the baseline law, unless that is kept beside its bag; None: where the
        extra for it is installed

    Raises BagError for the first bag that cannot be read, ParameterError for a scenario that cannot be, CommandError
    where an extra that is asked for is missing.
    """
    wanted = {BASELINE: baseline}
    extras = _extras(wanted)
    given = None if scenario is None else load_scenario(scenario, needs_files=False)
    with ProgressLine() as progress:
        records = analysis.analyse(
            bags,
            transient=transient,
            parameters=None if given is None else parameters_of(given),
            progress=lambda share: progress.show("analysing the bag", share if 0.0 < share < 1.0 else None),
        )
        for record, bag in zip(records, bags, strict=True):
            request = Request(bag, scenario or "", given, transient, wanted)
            for add in extras:
                warn(add(record, request, progress.show))
    return records


def _extras(wanted: Mapping[str, bool | None]) -> list[AddToRecord]:
    """Return what adds to a record; raise CommandError where the extra for something `wanted` (True) is missing."""
    found = []
    for name in known_parts(RECORD_EXTRAS):
        asked = wanted.get(name)
        if asked is False:
            continue
        try:
            found.append(load_part(RECORD_EXTRAS, name, f"--{name}"))
        except MissingExtraError as error:
            if asked:
                raise CommandError(str(error)) from error
    return found
