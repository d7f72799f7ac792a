"""The documents keep to the words of `docs/words.yaml`: the field's terms, in short sentences."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
import yaml

from tests.guide import GUIDE, READMES, ROOT

DOCUMENTS = [*GUIDE, *READMES, *sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))]
"""Pages that are written by hand; what is generated from the code says what the code says."""

AVOIDED = yaml.safe_load((ROOT / "docs" / "words.yaml").read_text(encoding="utf-8"))
LONGEST = 38
"""Words of a sentence outside tables: more is two sentences, or a list."""

_CODE = re.compile(r"^ *```.*?^ *```|`[^`]*`|\]\([^()\s]*\)|<!--.*?-->", re.DOTALL | re.MULTILINE)


def text_of(path: Path) -> str:
    """Return what a document says; of a notebook its cells of text."""
    text = path.read_text(encoding="utf-8")
    if path.suffix != ".ipynb":
        return text
    return "\n\n".join("".join(cell["source"]) for cell in json.loads(text)["cells"] if cell["cell_type"] == "markdown")


def prose(text: str) -> str:
    """Return a document without code, names in backquotes and targets of links; its lines stay where they are."""
    return _CODE.sub(lambda found: "\n" * found[0].count("\n") or " ", text)


def sentences(text: str) -> list[str]:
    """Return the sentences of a document outside its tables; a part before a colon or semicolon counts as one."""
    lines = "\n".join(line for line in prose(text).splitlines() if not line.lstrip().startswith("|"))
    paragraphs = re.split(r"\n\s*\n|\n(?=\s*(?:[-*] |\d+\. |#))", lines)
    return [part for words in paragraphs for part in re.split(r"(?<=[.:;?!])\s+", " ".join(words.split()))]


def avoided(text: str) -> list[str]:
    """Return each word of a document that it should not have: line, word, what to write."""
    found = []
    for number, line in enumerate(prose(text).splitlines(), 1):
        for pattern, better in AVOIDED.items():
            found += [f"{number}: {hit[0]!r}: {better}" for hit in re.finditer(pattern, line, re.IGNORECASE)]
    return found


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_a_document_uses_the_words_of_the_field(path):
    assert avoided(text_of(path)) == []


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_a_sentence_is_short(path):
    assert [found for found in sentences(text_of(path)) if len(found.split()) > LONGEST] == []


def test_each_word_to_avoid_is_found_and_code_is_not_looked_at():
    assert len(AVOIDED) > 15
    text = "The limit is told.\n```text\nmru suspect\n```\nIt reads `told`, and a [link](told.md) in force.\n"
    assert [hit.partition(": ")[0] for hit in avoided(text)] == ["1", "5"]
    assert prose(text).count("\n") == text.count("\n")
