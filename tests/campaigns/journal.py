"""The journal of a campaign: a heading, and a line of JSON for each case that was run, so that it can go on."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
PACKAGES = ("core", "node_base", "wave_vessel_node", "cable_sim_node", "winch_controller_node", "bringup/heave_bringup")
"""Places of the code that an outcome depends on."""
SOURCES = (".py", ".cpp", ".h", ".yaml")
"""What of it: sources and scenarios."""


class JournalError(ValueError):
    """A journal that is of another campaign, or cannot be read; the message says which, in one line."""


def sources_digest(others: Iterable[Path]) -> str:
    """Return a digest of the packages and of `others`, by which two commits with changes are distinguished."""
    digest = hashlib.sha256()
    paths = [path for package in PACKAGES for path in sorted((ROOT / package).rglob("*")) if path.suffix in SOURCES]
    for path in [*paths, *others]:
        if "test" not in path.parts:
            digest.update(path.read_bytes())
    return digest.hexdigest()[:12]


class JournalFile:
    """The file.

    Parameters
    ----------
    path : of the file; it is made where it is not there
    heading : of the campaign; None: whatever the file is of. Its commit is only a name for the sources

    Attributes
    ----------
    heading : of the file
    entries : of the cases that were run, by index: their words, and the values that were added

    Raises JournalError.
    """

    def __init__(self, path: Path, heading: Mapping[str, Any] | None = None) -> None:
        self._path = path
        self.entries: dict[int, tuple[str, dict[str, Any]]] = {}
        if heading is not None and not path.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(json.dumps(dict(heading)) + "\n", encoding="utf-8")
        try:
            first, *lines = path.read_text(encoding="utf-8").splitlines()
            self.heading: dict[str, Any] = dict(json.loads(first))
        except (OSError, ValueError, TypeError) as error:
            raise JournalError(f"{path}: no journal of draws: {error}") from error
        # a commit changes when the sources are committed, and they are the same
        if heading is not None and {**heading, "commit": ""} != {**self.heading, "commit": ""}:
            raise JournalError(f"{path}: is of {self.heading}, not of {dict(heading)}; name another with --journal")
        for line in lines:
            if not line:
                continue
            try:
                values = json.loads(line)
            except ValueError:  # it was being written when the campaign was ended
                continue
            self.entries[int(values.pop("index"))] = values.pop("words", ""), values

    def add(self, index: int, words: str, values: Mapping[str, Any]) -> None:
        """Write down what a case came to."""
        self.entries[index] = words, dict(values)
        with self._path.open("a", encoding="utf-8") as file:
            # a line of its own, also after one that was not finished
            file.write("\n" + json.dumps({"index": index, "words": words, **values}) + "\n")
