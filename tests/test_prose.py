"""Documents, docstrings and comments keep to the words of `docs/words.yaml`; sentences of documents are short."""

from __future__ import annotations

import ast
import io
import json
import re
import tokenize
from collections.abc import Iterable, Mapping
from pathlib import Path

import pytest
import yaml

from tests.guide import GUIDE, PAGES, READMES, ROOT

DOCUMENTS = [*GUIDE, *READMES, *PAGES, *sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))]
"""Pages that are written by hand; what is generated from the code says what the code says."""

_TABLE = yaml.safe_load((ROOT / "docs" / "words.yaml").read_text(encoding="utf-8"))
AVOIDED: Mapping[str, str] = _TABLE["everywhere"]
"""What to write for each pattern that is avoided in documents, docstrings and comments."""
AVOIDED_IN_DOCUMENTS: Mapping[str, str] = AVOIDED | _TABLE["documents"]
_ANY = re.compile("|".join(AVOIDED), re.IGNORECASE)
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


def avoided(text: str, table: Mapping[str, str] = AVOIDED_IN_DOCUMENTS) -> list[str]:
    """Return each word of a text that the `table` has: line, word, what to write."""
    found = []
    for number, line in enumerate(prose(text).splitlines(), 1):
        for pattern, better in table.items():
            found += [f"{number}: {hit[0]!r}: {better}" for hit in re.finditer(pattern, line, re.IGNORECASE)]
    return found


def words_of(source: str) -> str:
    """Return the docstrings and comments of Python `source`, each on its line; a docstring's names of arguments go."""
    if not _ANY.search(source):
        return ""
    strings = {
        (node.value.lineno, node.value.col_offset)
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
    }
    lines = [""] * (source.count("\n") + 1)
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT or (token.type == tokenize.STRING and token.start in strings):
            for place, text in enumerate(token.string.split("\n"), token.start[0] - 1):
                lines[place] = re.sub(r"^\s*\w+(, \w+)* : ", "", text)
    return "\n".join(lines)


def sources() -> Iterable[Path]:
    """Yield the Python files of the repository."""
    for folder in sorted(path for path in ROOT.iterdir() if path.is_dir() and path.name[0] not in "._"):
        yield from sorted(path for path in folder.rglob("*.py") if "node_modules" not in path.parts)


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_a_document_uses_the_words_of_the_field(path):
    assert avoided(text_of(path)) == []


def test_docstrings_and_comments_use_the_words_of_the_field():
    words = {path: words_of(path.read_text(encoding="utf-8")) for path in sources()}
    hits = {path: text for path, text in words.items() if _ANY.search(text)}
    assert [f"{path.relative_to(ROOT)}:{hit}" for path, text in hits.items() for hit in avoided(text, AVOIDED)] == []


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_a_sentence_is_short(path):
    assert [found for found in sentences(text_of(path)) if len(found.split()) > LONGEST] == []


def test_each_word_to_avoid_is_found_and_code_is_not_looked_at():
    assert len(AVOIDED) > 15
    text = "The limit is told.\n```text\nmru suspect\n```\nIt reads `told`, and a [link](told.md) in force.\n"
    assert [hit.partition(": ")[0] for hit in avoided(text)] == ["1", "5"]
    assert prose(text).count("\n") == text.count("\n")


def test_words_of_source_are_its_docstrings_and_comments_each_on_its_line():
    source = (
        'told = "told"  # told here\n\n\ndef f(told):\n    """Be told.\n\n    told : a name\n    x : `told`\n    """\n'
    )
    assert [hit.partition(": ")[0] for hit in avoided(words_of(source), AVOIDED)] == ["1", "5"]
