"""What all reports have in common."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from cable_sim_node.errors import PlantError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PICTURE_ENDINGS = (".png", ".svg")
"""Kinds of picture."""

PICTURE_SIZE = (11.0, 5.5)
"""Width and height of a picture [inch]."""


class Report(Protocol):
    """A report."""

    def table(self) -> str:
        """Return the report as text for a person."""

    def values(self) -> dict[str, object]:
        """Return the numbers with units in their names, for a machine."""

    def draw(self, figure: Figure) -> None:
        """Draw the report into an empty figure."""


class LoadReport(Report, Protocol):
    """A report of a cable at rest under load."""

    @property
    def largest_tension(self) -> float:
        """Largest tension at the boom tip in the report [N]."""

    @property
    def unit_load(self) -> float:
        """Largest tension of the cable at the unit [N]; NaN where there is no unit, or it is unknown."""


def save_picture(report: Report, path: Path) -> None:
    """Draw a report to a PNG or SVG file, by the ending of `path`.

    Raises
    ------
    PlantError
        for another ending.
    OSError
        where the file cannot be written.
    """
    from matplotlib import rc_context  # noqa: PLC0415 (slow to import, rarely needed)
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415 (slow to import, rarely needed)
    from matplotlib.figure import Figure  # noqa: PLC0415 (slow to import, rarely needed)

    if path.suffix.lower() not in PICTURE_ENDINGS:
        raise PlantError(f"{path}: the picture's name must end in {' or '.join(PICTURE_ENDINGS)}")
    figure = Figure(figsize=PICTURE_SIZE, layout="constrained")
    FigureCanvasAgg(figure)
    report.draw(figure)
    # text stays text, and equal pictures are equal files
    metadata = {"Date": None} if path.suffix.lower() == ".svg" else {}
    with rc_context({"svg.fonttype": "none", "svg.hashsalt": "heave"}):
        figure.savefig(path, dpi=120, metadata=metadata)


def labelled_rows(rows: Sequence[tuple[str, str]]) -> str:
    """Return a text of `rows` (name, value), the values in one column."""
    width = max(len(name) for name, _ in rows) + 2
    return "\n".join(f"{name:{width}}{text}" for name, text in rows)


def columns(headings: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a text of columns: `headings`, and `rows` of cells aligned to the right under them."""
    cells = [list(headings), *map(list, rows)]
    widths = [max(len(row[column]) for row in cells) for column in range(len(headings))]
    return "\n".join("  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)) for row in cells)
