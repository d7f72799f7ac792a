"""The figure of the estimator's innovations."""

from __future__ import annotations

import numpy as np

from heave_bags.analyse.reading.innovations import Innovation
from heave_bags.analyse.run_record import RunRecord
from heave_bags.report.figure import CM, KN, RUN_COLOURS, Figure, line, time_layout
from heave_bags.signals import Signal

INNOVATION_UNITS = {
    **dict.fromkeys(("mru_heave", "unit_heave", "payout"), "[cm]"),
    **dict.fromkeys(("mru_heave_rate", "unit_velocity"), "[m/s]"),
    "unit_acceleration": "[m/s²]",
    "tension": "[kN]",
}
"""Units by the names of measurements."""


def innovation_figure(record: RunRecord) -> Figure | None:
    """Innovations of the run `record` with the band of two predicted standard deviations, one row per measurement.

    None without an estimator.
    """
    rows = record.innovations
    if not rows:
        return None
    figure = Figure(
        "Estimator innovations",
        "Measurement minus prediction. Good: no trend, no oscillation, and 95 % inside the dotted lines, two predicted "
        "standard deviations. Wider: model or sensor is worse than stated.",
        layout=time_layout(record, ""),
        height=120 + 190 * len(rows),
    )
    gap = 0.08 / len(rows)
    for index, row in enumerate(map(_shown_innovation, rows)):
        axis = "y" if index == 0 else f"y{index + 1}"
        colour = RUN_COLOURS[index % len(RUN_COLOURS)]
        band = 2.0 * row.sigma
        edge = {"axis": axis, "dash": "dot", "width": 1.0}
        figure.traces += [
            line(Signal(row.time, row.value), row.name.replace("_", " "), colour, axis=axis, width=1.0),
            line(Signal(row.time, band), "2 sigma", "#888888", **edge) | {"showlegend": index == 0},
            line(Signal(row.time, -band), "2 sigma", "#888888", **edge) | {"showlegend": False},
        ]
        top = 1.0 - index / len(rows)
        name = "yaxis" + axis[1:]
        figure.layout[name] = {
            "title": {
                "text": f"{row.name.replace('_', ' ')}<br>{INNOVATION_UNITS.get(row.name, '')}".removesuffix("<br>")
            },
            "domain": [max(0.0, top - 1.0 / len(rows) + gap), top],
            "range": _settled_range(row, record),
        }
    figure.layout["xaxis"]["anchor"] = "y" if len(rows) == 1 else f"y{len(rows)}"
    return figure


def _shown_innovation(row: Innovation) -> Innovation:
    """Return an innovation in the unit in which people see its quantity."""
    scale = {"[cm]": CM, "[kN]": KN}.get(INNOVATION_UNITS.get(row.name, ""), 1.0)
    return Innovation(row.name, row.time, scale * row.value, scale * row.sigma)


def _settled_range(row: Innovation, record: RunRecord) -> list[float]:
    """Return the range that the evaluation window needs: the first innovations of a filter dwarf all others.

    A run that ended within its transient has its start-up in that window: then the second half counts.
    """
    begin = record.start if record.is_past_transient else 0.5 * (record.start + record.end)
    settled = (row.time >= begin) & (row.time <= record.end)
    shown = settled if settled.any() else np.ones(row.time.size, dtype=bool)
    reach = 1.15 * max(float(np.abs(row.value[shown]).max()), float(2.0 * row.sigma[shown].max()), 1e-9)
    return [-reach, reach]
