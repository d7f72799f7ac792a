"""One problem of a cable at rest, in several cases: a row of a table for each, and a picture of all of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from cable_sim_node.reports.report import columns
from heave_node.numerics.arrays import Array
from heave_node.sheet import Sheet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


class SideView(NamedTuple):
    """A cable from the side."""

    label: str  # of the case
    along: Array  # places along the direction of view, from the lower end upwards [m]
    height: Array  # z of these places [m]


@dataclass(frozen=True)
class Sides:
    """The cables of all cases from the side, and the words of their picture."""

    views: Sequence[SideView]  # of each case
    legend: str  # what their labels are
    along: str  # label of the horizontal axis
    depth: float | None = None  # of the bottom [m]; None: there is none, and the lower end is a unit

    def draw(self, axis: Axes) -> None:
        """Draw them into an `axis`."""
        for view in self.views:
            (line,) = axis.plot(view.along, view.height, label=view.label)
            if self.depth is None:
                axis.plot(view.along[0], view.height[0], "s", color=line.get_color())
        if self.depth is None:
            axis.axhline(0.0, color="tab:blue", linewidth=0.8, alpha=0.5)
        else:
            axis.axhline(-self.depth, color="saddlebrown", linewidth=2.0)
        title = "cable and unit from the side" if self.depth is None else "cable from the side"
        axis.set(xlabel=self.along, ylabel="z [m]", title=title)
        axis.legend(title=self.legend, fontsize="small")


@dataclass(frozen=True)
class CasesReport:
    """The cases of a problem."""

    sheet: Sheet  # columns of the table
    name: str  # of the cases, for a machine
    rows: tuple[Any, ...]  # one for each case
    common: Mapping[str, Any]  # numbers that are the same in all cases, with units in their names
    largest_tension: float  # at the boom tip in any of the cases [N]
    side: Callable[[Axes], None]  # draws the cables from the side
    other: Callable[[Axes], None]  # draws what depends on the case
    unit_load: float = math.nan  # largest force of the cable on the unit in any of them [N]; NaN: it holds none
    notes: tuple[str, ...] = ()  # lines below the table

    def values(self) -> dict[str, object]:
        """Return the numbers with units in their names, for a machine."""
        return {**self.common, self.name: self.sheet.records(self.rows)}

    def table(self) -> str:
        """Return the report as text for a person."""
        return "\n".join([columns(self.sheet.headings, self.sheet.cells(self.rows)), *self.notes])

    def draw(self, figure: Figure) -> None:
        """Draw the cable from the side, and what depends on the case, into `figure`."""
        for axis, panel in zip(figure.subplots(1, 2), (self.side, self.other), strict=True):
            panel(axis)
            axis.grid(alpha=0.3)


def draw_curves(
    rows: Sequence[Any], over: str, curves: Mapping[str, str], words: Mapping[str, str], scale: float, axis: Axes
) -> None:
    """Draw what depends on the cases.

    Parameters
    ----------
    rows : of the cases
    over : attribute of a row, dotted, in which they differ
    curves : attribute of what is drawn, by name
    words : labels and title of the axis
    scale : from SI to the unit of what is drawn
    axis : of the picture
    """
    for marker, (name, attribute) in zip("os^", curves.items(), strict=False):
        places = [attrgetter(over)(row) for row in rows]
        axis.plot(places, [scale * attrgetter(attribute)(row) for row in rows], f"{marker}-", label=name)
    axis.set(**words)
    axis.legend(fontsize="small")


def unit_vector(course: float) -> Array:
    """Return the horizontal unit vector, x and y, of a `course` from x towards y [rad]."""
    return np.array([math.cos(course), math.sin(course)])
