"""What the documents say to type: the blocks of code of a Markdown file, in order; whole, or as short as it can be run.

`shortened` changes nothing but simulated times: how long a run lasts, and after which time it is judged. Every command,
option, file and line of Python stays as it is printed.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / f"{name}.md" for name in ("ARCHITECTURE", "CHANGELOG", "CONTRIBUTING", "README")]
"""Pages at the top; others there are a user's own."""
GUIDE = sorted((ROOT / "docs" / "guide").rglob("*.md"))
_FOUND = (path for levels in range(1, 6) for path in ROOT.glob("/".join(["[a-z]*"] * levels) + "/README.md"))
READMES = sorted(path for path in _FOUND if "node_modules" not in path.parts)
_BLOCK = re.compile(r'^(<!-- not run -->\n)?```(\w+)(?: title="([^"]+)")?\n(.*?)^```', re.DOTALL | re.MULTILINE)

SHARE = 0.06
"""Share of a printed duration, and of its transient, that is run where time is short."""
_TRANSIENT = 120.0
"""Transient of the shipped scenarios [s]."""
_NUMBER = r"\d+(?:\.\d+)?"


@dataclass(frozen=True)
class Block:
    """A block of code: its language, the file that it is saved as ("": none), its text, and whether it is run."""

    language: str
    title: str
    text: str
    is_run: bool


def blocks(path: Path) -> list[Block]:
    """Return the blocks of code in a file; `<!-- not run -->` before one says that it needs more than a shell."""
    found = _BLOCK.findall(path.read_text(encoding="utf-8"))
    return [Block(language, title, text, not mark) for mark, language, title, text in found]


def shortened(text: str, share: float = SHARE) -> str:
    """Return commands or Python with a `share` of the simulated time that they state.

    What states none stays whole, and so does a run that must give a certain figure (`--require`).
    """

    def less(found: re.Match[str]) -> str:
        numbers = ", ".join(f"{share * float(number):g}" for number in found[1].split(", "))
        return found[0].replace(found[1], numbers)

    transient = f"{share * _TRANSIENT:g}"
    # what is left out at the start of a run has to follow its duration
    for duration, addition in (
        (r"heave (?:run|operability|sizing) (?!.*--require).*--duration \S+", f" --set all.transient={transient}"),
        (r'"all\.duration=\d+"', f', "all.transient={transient}"'),
        (r"^duration: .+", f"\nset: {{all.transient: {transient}}}"),
    ):
        text = re.sub(f"({duration})", lambda found, addition=addition: found[1] + addition, text, flags=re.MULTILINE)
    for stated in (
        rf"--duration ({_NUMBER})(?= --set all)",
        rf"\ball\.duration=({_NUMBER})",
        rf"^duration: ({_NUMBER})$",
        rf"\bafter=({_NUMBER})",
        rf"^DURATION, [A-Z, ]+ = ({_NUMBER}(?:, {_NUMBER})*)$",  # the line of a notebook that holds its times
    ):
        text = re.sub(stated, less, text, flags=re.MULTILINE)
    return text
