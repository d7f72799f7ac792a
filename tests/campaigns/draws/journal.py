"""The journal of a campaign: a line for each draw that was run, so that it can go on, and be printed again."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from tests.campaigns.draws.cases import Case, draw
from tests.campaigns.draws.run import Outcome
from tests.campaigns.journal import JournalError, JournalFile
from tests.campaigns.journal import sources_digest as digest_of

DRAWING = ("chance", "deviation", "table", "seas", "operations", "lifts", "cases", "findings", "run")
"""Files beside this one that an outcome depends on, besides the packages."""


def sources_digest() -> str:
    """Return a digest of the code, by which two commits with changes are distinguished."""
    return digest_of(Path(__file__).with_name(f"{name}.py") for name in DRAWING)


@dataclass(frozen=True)
class Heading:
    """What a journal is of."""

    commit: str  # of the code
    sources: str  # of the code
    kind: str  # of the draws
    day: int  # of the draws
    latency: str  # of what the controller finds [s], or "true"; empty: its own
    is_informed: bool  # the draws for which that is possible are run with an informed controller as well
    without: str = ""  # part of the controller that is switched off; empty: none

    @property
    def draws(self) -> tuple[str, int]:
        """Return what its draws are fixed by, but for their index."""
        return self.kind, self.day

    @property
    def file_name(self) -> str:
        """Return the name of its file."""
        late = f"-late-{self.latency}" if self.latency else ""
        without = f"-without-{self.without.replace(' ', '-')}" if self.without else ""
        return f"{self.kind}-{self.day}-{self.sources}{late}{without}{'-told' if self.is_informed else ''}.jsonl"


class Journal:
    """Draws that were run.

    Parameters
    ----------
    path : of the file; it is made where it is not there
    heading : of the campaign; None: whatever the file is of

    Attributes
    ----------
    heading : of the file
    outcomes : by the index of the draw, of those that the table draws as it did

    Raises JournalError.
    """

    def __init__(self, path: Path, heading: Heading | None = None) -> None:
        self._file = JournalFile(path, None if heading is None else asdict(heading))
        self.outcomes: dict[int, Outcome] = {}
        try:
            self.heading = Heading(**self._file.heading)
        except TypeError as error:
            raise JournalError(f"{path}: no journal of draws: {error}") from error
        for index, (words, values) in self._file.entries.items():
            # by another table another case is drawn
            if words == draw(*self.heading.draws, index).words:
                self.outcomes[index] = _outcome(values)

    def add(self, case: Case, outcome: Outcome) -> None:
        """Write down what a `case` came to."""
        self.outcomes[case.index] = outcome
        self._file.add(case.index, case.words, asdict(outcome))


def _outcome(values: Mapping[str, Any]) -> Outcome:
    lists = {name: tuple(value) for name, value in values.items() if isinstance(value, list)}
    alarms = tuple((float(time), str(words)) for time, words in lists["alarms"])
    return Outcome(**{**values, **lists, "alarms": alarms})
