"""One problem of a cable at rest, in several cases: a row of a table for each, and a picture of all of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from cable_sim_node.reports.report import columns
from heave_node.numerics.arrays import Array
from heave_node.sheet import Sheet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class CasesReport:
    """The cases of a problem."""

    sheet: Sheet  # columns of the table
    name: str  # of the cases, for a machine
    rows: tuple[Any, ...]  # one for each case
    common: Mapping[str, Any]  # numbers that are the same in all cases, with units in their names
    largest_tension: float  # at the boom tip in any of the cases [N]
    panels: Callable[[Axes, Axes], None]  # draws the two panels of the picture
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
        side, other = figure.subplots(1, 2)
        self.panels(side, other)
        for axis in (side, other):
            axis.grid(alpha=0.3)


class SideView(NamedTuple):
    """A cable from the side."""

    label: str  # of the case
    along: Array  # places along the direction of view, from the lower end upwards [m]
    height: Array  # z of these places [m]


def draw_sides(axis: Axes, views: Sequence[SideView], *, legend: str, along: str, depth: float | None = None) -> None:
    """Draw cables from the side.

    Parameters
    ----------
    axis : of the picture
    views : of each case
    legend : what their labels are
    along : label of the horizontal axis
    depth : of the bottom [m]; None: there is none, and the lower end is a unit
    """
    for view in views:
        (line,) = axis.plot(view.along, view.height, label=view.label)
        if depth is None:
            axis.plot(view.along[0], view.height[0], "s", color=line.get_color())
    if depth is None:
        axis.axhline(0.0, color="tab:blue", linewidth=0.8, alpha=0.5)
    else:
        axis.axhline(-depth, color="saddlebrown", linewidth=2.0)
    title = "cable and unit from the side" if depth is None else "cable from the side"
    axis.set(xlabel=along, ylabel="z [m]", title=title)
    axis.legend(title=legend, fontsize="small")


def draw_curves(axis: Axes, over: Sequence[float], curves: Mapping[str, Sequence[float]], **words: str) -> None:
    """Draw `curves` by name `over` what the cases differ in; `words` are labels and title of the `axis`."""
    for marker, (name, values) in zip("os^", curves.items(), strict=False):
        axis.plot(over, values, f"{marker}-", label=name)
    axis.set(**words)
    axis.legend(fontsize="small")


def unit_vector(course: float) -> Array:
    """Return the horizontal unit vector, x and y, of a `course` from x towards y [rad]."""
    return np.array([math.cos(course), math.sin(course)])
