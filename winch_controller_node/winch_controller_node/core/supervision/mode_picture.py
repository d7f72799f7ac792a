"""The table of modes as a page: a state diagram and every row in words.

python -m winch_controller_node.core.supervision.mode_picture > docs/modes.md
"""

from __future__ import annotations

import sys

from winch_controller_node.core.supervision.modes import TABLE, Transition

HEADER = """# Modes of the winch controller

This page is generated from the table in `winch_controller_node/core/supervision/modes.py` by
`python -m winch_controller_node.core.supervision.mode_picture > docs/modes.md`; a test keeps the two in step.

Rows are tried from the top; the first whose guards all hold applies. A request that matches no row is refused with
the guards that do not hold.
"""


def diagram() -> str:
    """Return the changes of mode as a mermaid state diagram; one arrow for each pair of modes."""
    arrows: dict[tuple[str, str], list[str]] = {}
    for row in TABLE:
        for source in row.sources:
            if source is not row.target:
                events = arrows.setdefault((source.value, row.target.value), [])
                events += [row.event.value] if row.event.value not in events else []
    lines = [f"    {source} --> {target}: {', '.join(events)}" for (source, target), events in arrows.items()]
    return "\n".join(["stateDiagram-v2", "    [*] --> standby", "    [*] --> off: law off", *lines])


def _words(row: Transition) -> tuple[str, str, str, str, str]:
    target = "stays" if row.sources == (row.target,) else row.target.value
    return (
        ", ".join(mode.value for mode in row.sources),
        row.event.value,
        "; ".join(guard.name for guard in row.guards),
        "; ".join(action.__name__.replace("_", " ") for action in row.actions),
        target,
    )


def page() -> str:
    """Return the page as Markdown."""
    rows = ["| mode | event | guards | actions | next mode |", "|---|---|---|---|---|"]
    rows += [f"| {' | '.join(_words(row))} |" for row in TABLE]
    return "\n".join([HEADER, "```mermaid", diagram(), "```", "", *rows, ""])


if __name__ == "__main__":
    sys.stdout.write(page())
