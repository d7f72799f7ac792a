"""Parts of pages as HTML: notices and tables."""

from __future__ import annotations

import html
from collections.abc import Iterable, Sequence


def notice(text: str) -> str:
    """Return a `text` that must be seen, as HTML."""
    return f'<div class="notice">{html.escape(text)}</div>'


def table(head: Sequence[str], rows: Iterable[Sequence[str]], *, texts: int, last_is_text: bool = False) -> str:
    """Return an HTML table with the `head` of its columns and `rows` of cells.

    The first `texts` columns hold text, and the last one where `last_is_text`; the others numbers.
    """
    last = len(head) - 1

    def cell(tag: str, column: int, text: str) -> str:
        is_text = column < texts or (last_is_text and column == last)
        kind = "" if is_text else ' class="number"'
        return f"<{tag}{kind}>{html.escape(text)}</{tag}>"

    top = "".join(cell("th", column, text) for column, text in enumerate(head))
    lines = "\n".join(
        f"<tr>{''.join(cell('td', column, text) for column, text in enumerate(row))}</tr>" for row in rows
    )
    return f'<div class="scroll"><table><thead><tr>{top}</tr></thead><tbody>{lines}</tbody></table></div>'
