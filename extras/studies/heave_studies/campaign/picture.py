"""Pictures of a campaign: a figure of merit over what was varied, compensated beside uncompensated."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np
import pandas
from heave_bags.analyse import kpi_set

from heave_studies.campaign.table import FAILURE, LOST, SEED, settings_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ENDINGS = (".png", ".svg", ".pdf")
UNCOMPENSATED = {
    "unit_sigma_m": "uncompensated_sigma_m",
    "max_abs_heave_m": "uncompensated_max_abs_heave_m",
    "dynamic_amplification": "uncompensated_dynamic_amplification",
    "tension_ratio_min": "uncompensated_tension_ratio_min",
    "snaps": "uncompensated_snaps",
}
"""Figures that are known of the same sea with the winch locked as well."""

MOST_PANELS = 6


def save_picture(frame: pandas.DataFrame, kpi: str, path: Path) -> None:
    """Draw a figure of merit over each parameter that was varied, or over the seed where none was.

    Parameters
    ----------
    frame : of a campaign
    kpi : key of the figure
    path : .png, .svg or .pdf
    """
    pyplot = load_pyplot()
    good = frame[frame[FAILURE] == ""]
    places = [place for place in settings_of(frame) if good[place].astype(str).nunique() > 1][:MOST_PANELS] or [SEED]
    columns = min(len(places), 3)
    rows = -(-len(places) // columns)
    figure, axes = pyplot.subplots(rows, columns, figsize=(1.5 + 4.0 * columns, 3.4 * rows), squeeze=False, sharey=True)
    for axis, place in zip(axes.flat, places, strict=False):
        _panel(axis, good, place, kpi)
    for axis in axes.flat[len(places) :]:
        axis.set_visible(False)
    definition = kpi_set.DEFINITION_OF[kpi]
    unit = f" [{definition.unit}]" if definition.unit else ""
    for axis in axes[:, 0]:
        axis.set_ylabel(f"{definition.title}{unit}", fontsize=8)
    axes[0, 0].legend(fontsize=8, frameon=False)
    figure.tight_layout()
    save_figure(figure, path)


def _panel(axis: Axes, good: pandas.DataFrame, place: str, kpi: str) -> None:
    scale = kpi_set.DEFINITION_OF[kpi].scale
    values, labels = _numbers(good[place])
    if kpi in UNCOMPENSATED:
        off = good[UNCOMPENSATED[kpi]] * scale
        axis.plot(values, off, "o", ms=4, mfc="none", color="#999999", label="uncompensated")
    lost = good[LOST].to_numpy(dtype=bool)
    axis.plot(values[~lost], good.loc[~lost, kpi] * scale, "o", ms=4, color="#009e73", label="compensated")
    if lost.any():
        axis.plot(values[lost], good.loc[lost, kpi] * scale, "x", ms=6, color="#d55e00", label="lost")
    if labels:
        axis.set_xticks(range(len(labels)), labels, fontsize=8)
    axis.set_xlabel(place, fontsize=8)
    axis.grid(color="#e6ecf1")
    axis.set_ylim(bottom=0.0)


def _numbers(column: pandas.Series) -> tuple[np.ndarray, list[str]]:
    """Return the values of a parameter as numbers; words and lists are numbered, and their labels given."""
    if pandas.api.types.is_numeric_dtype(column) and not pandas.api.types.is_bool_dtype(column):
        return column.to_numpy(dtype=float), []
    codes, names = pandas.factorize(column.astype(str))
    return codes.astype(float), list(names)


def load_pyplot() -> ModuleType:
    """Return pyplot, which draws without a screen; it is slow to import."""
    import matplotlib as mpl  # noqa: PLC0415

    mpl.use("Agg")
    mpl.rcParams["svg.hashsalt"] = "heave"  # equal tables give equal bytes
    from matplotlib import pyplot  # noqa: PLC0415

    return pyplot


def save_figure(figure: Figure, path: Path) -> None:
    """Write a `figure` to a `path` (.png, .svg or .pdf), equal figures as equal bytes, and close it."""
    figure.savefig(path, dpi=130, metadata={"Date": None} if path.suffix == ".svg" else None)
    load_pyplot().close(figure)
