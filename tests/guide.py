"""What the documents say to type: the blocks of code of a Markdown file, in order."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
GUIDE = sorted((ROOT / "docs" / "guide").rglob("*.md"))
READMES = sorted(path for levels in range(1, 6) for path in ROOT.glob("/".join(["[a-z]*"] * levels) + "/README.md"))
_BLOCK = re.compile(r'^(<!-- not run -->\n)?```(\w+)(?: title="([^"]+)")?\n(.*?)^```', re.DOTALL | re.MULTILINE)


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
