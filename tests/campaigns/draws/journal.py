"""The journal of a campaign: a line for each draw that was run, so that it can go on, and be printed again."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from tests.campaigns.draws.cases import Case, draw
from tests.campaigns.draws.run import Outcome

ROOT = Path(__file__).parents[3]
PACKAGES = ("node_base", "wave_vessel_node", "cable_sim_node", "winch_controller_node", "bringup/heave_bringup")
DRAWING = ("chance", "deviation", "table", "seas", "operations", "lifts", "cases", "findings", "run")
"""Places of the code that an outcome depends on: packages, and files beside this one."""


class JournalError(ValueError):
    """A journal that is of another campaign, or cannot be read; the message says which, in one line."""


def sources_digest() -> str:
    """Return a digest of the code, by which two commits with changes are distinguished."""
    digest = hashlib.sha256()
    paths = [path for package in PACKAGES for path in sorted((ROOT / package).rglob("*.py"))]
    for path in [*paths, *(Path(__file__).with_name(f"{name}.py") for name in DRAWING)]:
        if "test" not in path.parts:
            digest.update(path.read_bytes())
    return digest.hexdigest()[:12]


@dataclass(frozen=True)
class Heading:
    """What a journal is of.

    Attributes
    ----------
    commit, sources : of the code
    kind, day : of the draws
    latency : of what the controller finds [s], or "true"; empty: its own
    is_informed : the draws for which that is possible are run with an informed controller as well
    without : part of the controller that is switched off; empty: none
    """

    commit: str
    sources: str
    kind: str
    day: int
    latency: str
    is_informed: bool
    without: str = ""

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
        self._path = path
        self.outcomes: dict[int, Outcome] = {}
        if heading is not None and not path.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(json.dumps(asdict(heading)) + "\n", encoding="utf-8")
        try:
            first, *lines = path.read_text(encoding="utf-8").splitlines()
            self.heading = Heading(**json.loads(first))
        except (OSError, ValueError, TypeError) as error:
            raise JournalError(f"{path}: no journal of draws: {error}") from error
        # a commit is only a name for the sources: it changes when they are committed
        if heading is not None and _without_commit(heading) != _without_commit(self.heading):
            raise JournalError(f"{path}: is of {self.heading}, not of {heading}; name another with --journal")
        for line in lines:
            if not line:
                continue
            try:
                values = json.loads(line)
            except ValueError:  # it was being written when the campaign was ended
                continue
            index, words = int(values.pop("index")), values.pop("words", "")
            # by another table another case is drawn
            if words == draw(*self.heading.draws, index).words:
                self.outcomes[index] = _outcome(values)

    def add(self, case: Case, outcome: Outcome) -> None:
        """Write down what a `case` came to."""
        self.outcomes[case.index] = outcome
        with self._path.open("a", encoding="utf-8") as file:
            # a line of its own, also after one that was not finished
            file.write("\n" + json.dumps({"index": case.index, "words": case.words, **asdict(outcome)}) + "\n")


def _without_commit(heading: Heading) -> dict[str, object]:
    return {name: value for name, value in asdict(heading).items() if name != "commit"}


def _outcome(values: Mapping[str, Any]) -> Outcome:
    lists = {name: tuple(value) for name, value in values.items() if isinstance(value, list)}
    alarms = tuple((float(time), str(words)) for time, words in lists["alarms"])
    return Outcome(**{**values, **lists, "alarms": alarms})
