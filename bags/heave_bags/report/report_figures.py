"""The figures of a report: motions, tension, winch, estimator and timing over the time of the run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from heave_node.tick.durations import EDGES, LAST

from heave_bags.analyse import events
from heave_bags.analyse.events import Interval
from heave_bags.analyse.kpi_set import FREE_HEAVE
from heave_bags.analyse.reading.innovations import Innovation
from heave_bags.analyse.run_record import ESTIMATED, TRUE, RunRecord
from heave_bags.report.figure import (
    BOOM_TIP,
    CM,
    KN,
    LIMIT,
    OTHER,
    PAYOUT,
    RUN_COLOURS,
    UNCOMPENSATED,
    UNCOUNTED,
    UNIT,
    Figure,
    about_mean,
    limit_line,
    line,
    time_layout,
    transient_band,
)
from heave_bags.report.spectrum_figures import comparison_of_spectra, spectrum_figure, spectrum_lines
from heave_bags.signals import Signal

AT_LIMIT = "#8c564b"
LEVEL_NAMES = {1: "warning", 2: "error"}
LEVEL_COLOURS = ("#0072b2", "#e69f00", "#d55e00")
MODE_COLOURS = {
    "off": "#bbbbbb",
    "standby": "#56b4e9",
    "compensating": "#009e73",
    "constant_tension": "#0072b2",
    "fade_out": "#e69f00",
    "stopping": "#f0e442",
    "stopped": "#d55e00",
    "emergency_stop": "#d55e00",
}
FREE_MOTION = {TRUE: "computed beside the run", ESTIMATED: "as the controller estimates it"}
"""How the motion of the uncompensated unit is known, by its source."""
MOST_MODES = 12
"""Modes or limits that a legend names; a bag may bring any number."""


SHOWN = 0.5
"""Time for which what happened at one time is drawn, so that it is seen [s]."""


def run_figures(record: RunRecord) -> list[Figure]:
    """Return the figures of the run `record`; those whose signals were not recorded are left out."""
    signals = record.signals
    figures: list[Figure | None] = [motion_figure(record)]
    figures.append(unit_figure(record) if signals.unit_heave.size else None)
    figures.append(tension_figure(record) if signals.tension.size else None)
    figures.append(winch_figure(record) if signals.payout_rate.size else None)
    figures.append(spectrum_figure(record) if spectrum_lines(record) else None)
    figures.append(innovation_figure(record))
    figures.append(timing_figure(record))
    return [figure for figure in figures if figure is not None]


def comparison_figures(records: Sequence[RunRecord], names: Sequence[str]) -> list[Figure]:
    """Return the figures that show the runs `records` together, each by its name among `names`."""
    grey = " Grey: transient, not counted." if transient_band(records[0]) else ""
    heave = Figure(
        "Load heave of all runs",
        f"About the mean of each run.{grey}",
        layout=time_layout(records[0], "load heave about the mean [cm]"),
    )
    for index, (record, label) in enumerate(zip(records, names, strict=True)):
        colour = RUN_COLOURS[index % len(RUN_COLOURS)]
        heave.traces.append(line(about_mean(record.signals.unit_heave), label, colour))
    return [heave, comparison_of_spectra(records, names)]


def motion_figure(record: RunRecord) -> Figure:
    """Boom tip, minus payout and unit about their means, below the ribbon of modes, limits and alarms of `record`."""
    signals = record.signals
    minus_payout = Signal(signals.payout.time, -signals.payout.value)
    ribbon = ribbon_traces(record)
    figure = Figure(
        "Motion",
        "Heave about the mean: boom tip minus payout is the motion of the rope at the boom tip. "
        "Above: controller mode, brake, active winch limits and alarms, in the colours below.",
        layout=time_layout(record, "heave about the mean [cm]"),
        height=480,
    )
    figure.traces += [
        line(about_mean(signals.boom_tip_heave), "boom tip", BOOM_TIP),
        line(about_mean(minus_payout), "minus payout", PAYOUT),
        line(about_mean(signals.unit_heave), "load", UNIT, width=1.8),
    ]
    figure.legend = ribbon_legend(record)
    if ribbon:
        rows = [row for row in ("alarms", "limits", "brake", "mode") if any(trace["y"][0] == row for trace in ribbon)]
        figure.traces += ribbon
        figure.layout["yaxis"]["domain"] = [0.0, 0.78]
        order = {"type": "category", "categoryorder": "array", "categoryarray": rows}
        figure.layout["yaxis2"] = {"domain": [0.82, 1.0], **order, "fixedrange": True, "showgrid": False}
    return figure


def _ribbon(intervals: Sequence[Interval], row: str, colour: str, name: str) -> dict[str, Any]:
    """Return intervals as a thick line in the row `row` of the ribbon."""
    x = [time for one in intervals for time in (one.start, max(one.end, one.start + SHOWN), None)]
    texts = [text for one in intervals for text in (one.name, one.name, None)]
    drawn = {"mode": "lines", "line": {"color": colour, "width": 13}, "yaxis": "y2", "showlegend": False}
    hover = {"text": texts, "hovertemplate": "%{text}: %{x:.1f} s<extra></extra>"}
    return {"name": name, "x": x, "y": [row, row, None] * len(intervals), **drawn, **hover}


def ribbon_traces(record: RunRecord) -> list[dict[str, Any]]:
    """Return the mode and alarm ribbon of the run `record`: one row each for modes, brake, active limits, alarms."""
    traces = []
    for mode in dict.fromkeys(interval.name for interval in record.modes):
        part = [interval for interval in record.modes if interval.name == mode]
        traces.append(_ribbon(part, "mode", MODE_COLOURS.get(mode, OTHER), mode))
    for row, colour in (("brake", OTHER), ("limits", AT_LIMIT)):
        acted = [interval for interval in record.limits if (interval.name == "brake") == (row == "brake")]
        if acted:
            traces.append(_ribbon(acted, row, colour, row))
    for level in LEVEL_NAMES:
        alarms = [interval for interval in record.alarms if interval.level == level]
        if alarms:
            traces.append(_ribbon(alarms, "alarms", LEVEL_COLOURS[level], "alarms"))
    return traces


def ribbon_legend(record: RunRecord) -> list[tuple[str, str]]:
    """Return what the colours of the ribbon of the run `record` mean: modes, brake, winch limits, alarms."""
    modes = list(dict.fromkeys(mode.name for mode in record.modes))[:MOST_MODES]
    found = [(f"mode {mode.replace('_', ' ')}", MODE_COLOURS.get(mode, OTHER)) for mode in modes]
    limits = list(dict.fromkeys(limit.name for limit in record.limits if limit.name != "brake"))[:MOST_MODES]
    found += [("brake on", OTHER)] if any(limit.name == "brake" for limit in record.limits) else []
    found += [(f"winch at a limit: {', '.join(limits)}", AT_LIMIT)] if limits else []
    levels = {alarm.level for alarm in record.alarms}
    found += [
        (f"alarm, {name}", LEVEL_COLOURS[level]) for level, name in ((1, "warning"), (2, "error")) if level in levels
    ]
    return [*found, *([UNCOUNTED] if transient_band(record) else [])]


def unit_figure(record: RunRecord) -> Figure:
    """Unit heave with and without compensation, of the run `record`."""
    signals, source = record.signals, record.sources.get(FREE_HEAVE, TRUE)
    figure = Figure(
        "Load heave, compensated and with the winch locked",
        f"Winch locked: the same sea and rope, {FREE_MOTION[source]}.",
        layout=time_layout(record, "load heave about the mean [cm]"),
    )
    figure.traces += [
        line(about_mean(signals.uncompensated_heave), "winch locked", UNCOMPENSATED),
        line(about_mean(signals.unit_heave), "compensated", UNIT, width=1.6),
    ]
    return figure


def tension_figure(record: RunRecord) -> Figure:
    """Top tension of the run `record` with its static value, slack and snap limits.

    The static value is a line where the deployed length changes.
    """
    static = record.signals.static_tension
    tension = record.signals.tension
    is_steady = static.size == 1
    shapes = limit_line(0.0, "slack")
    for share, name in ((1.0, "static"), (1.3, "1.3 static"), (0.1, "0.1 static")) if is_steady else ():
        shapes += limit_line(share * static.value[0] * KN, name)
    figure = Figure(
        "Top tension",
        "A snap is a tension below 0.1 of the static one followed by more than 1.3 of it within 2 s.",
        layout=time_layout(record, "top tension [kN]", shapes),
    )
    figure.traces.append(line(Signal(tension.time, tension.value * KN), "top tension", BOOM_TIP))
    shown = np.concatenate([tension.value * KN, static.value * KN, [shape["y0"] for shape in shapes]])
    shown = shown[np.isfinite(shown)]
    lowest, highest = float(shown.min()), float(shown.max())
    margin = 0.08 * (highest - lowest)  # the lines and their names keep clear of the frame
    figure.layout["yaxis"]["range"] = [lowest - margin, highest + margin]
    if static.size > 1:
        figure.traces.append(line(Signal(static.time, static.value * KN), "static", LIMIT, dash="dash"))
    return figure


def winch_figure(record: RunRecord) -> Figure:
    """Winch speed and acceleration of the run `record` with their limits."""
    signals = record.signals
    shapes = [shape for sign in (1, -1) for shape in limit_line(sign * signals.speed_limit, "speed limit")]
    for sign in (1, -1):
        shapes += limit_line(sign * signals.acceleration_limit, "acceleration limit", "y2")
    learnt = [*_identified_limit(record, "speed", "y"), *_identified_limit(record, "acceleration", "y2")]
    figure = Figure(
        "Winch speed and acceleration",
        "Positive pays out and lowers the load. Dashed: limits of the winch as stated"
        + ("; dotted: limits that the controller has identified, from when it reported them." if learnt else "."),
        layout=time_layout(record, "payout rate [m/s]", shapes),
        height=520,
    )
    figure.traces += [
        line(signals.payout_rate, "payout rate", PAYOUT),
        line(signals.payout_acceleration, "payout acceleration", OTHER, axis="y2"),
        *learnt,
    ]
    figure.layout["yaxis"]["domain"] = [0.54, 1.0]
    figure.layout["yaxis2"] = {"title": {"text": "acceleration [m/s²]"}, "domain": [0.0, 0.46]}
    figure.layout["xaxis"]["anchor"] = "y2"
    return figure


def _identified_limit(record: RunRecord, quantity: str, axis: str) -> list[dict[str, Any]]:
    """Return the limit of the winch on a `quantity`, speed or acceleration, that was learnt in the run `record` as two
    lines on an `axis`, in steps; nothing where none was.
    """
    learnt = events.identified_limits(record.alarms, quantity)
    if not learnt:
        return []
    times = np.repeat([*(time for time, _ in learnt), max(record.end, learnt[-1][0])], 2)[1:-1]
    values = np.repeat([value for _, value in learnt], 2)
    name, style = f"{quantity} limit, learnt", {"axis": axis, "dash": "dot"}
    return [
        line(Signal(times, values), name, LIMIT, **style),
        line(Signal(times, -values), name, LIMIT, **style) | {"showlegend": False},
    ]


def timing_figure(record: RunRecord) -> Figure | None:
    """Return the histograms of durations in wall time: loop age, and how messages of external nodes came in.

    None where `record` has none.
    """
    if not record.timings:
        return None
    traces = [
        {
            "type": "bar",
            "name": name,
            "x": [f"<= {edge}" if edge != LAST else LAST for edge in counts],
            "y": list(counts.values()),
        }
        for name, counts in record.timings.items()
    ]
    edges = [f"<= {1e3 * edge:g}" for edge in EDGES]
    layout = {
        "xaxis": {"title": {"text": "wall time [ms]"}, "categoryorder": "array", "categoryarray": [*edges, LAST]},
        "yaxis": {"title": {"text": "count"}, "type": "log"},
        "barmode": "group",
    }
    caption = "Every tick counts, those that missed their deadline with the time until their last answer."
    return Figure("Timing", caption, traces, layout, is_over_time=False)


INNOVATIONS = {
    "mru_heave": ("MRU heave", "[cm]"),
    "mru_heave_rate": ("MRU heave rate", "[m/s]"),
    "unit_heave": ("load heave", "[cm]"),
    "unit_velocity": ("load velocity", "[m/s]"),
    "unit_acceleration": ("load acceleration", "[m/s²]"),
    "payout": ("encoder payout", "[cm]"),
    "tension": ("hook load", "[kN]"),
}
"""What readers call a measurement, and the unit in which they see it, by the name that the estimator gives it."""


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
        words, unit = INNOVATIONS.get(row.name, (row.name, ""))
        axis = "y" if index == 0 else f"y{index + 1}"
        band = 2.0 * row.sigma
        edge = {"axis": axis, "dash": "dot", "width": 1.0}
        figure.traces += [
            line(Signal(row.time, row.value), words, RUN_COLOURS[index % len(RUN_COLOURS)], axis=axis, width=1.0),
            line(Signal(row.time, band), "2 sigma", "#888888", **edge) | {"showlegend": index == 0},
            line(Signal(row.time, -band), "2 sigma", "#888888", **edge) | {"showlegend": False},
        ]
        top = 1.0 - index / len(rows)
        figure.layout[f"yaxis{axis[1:]}"] = {
            "title": {"text": f"{words}<br>{unit}".removesuffix("<br>")},
            "domain": [max(0.0, top - 1.0 / len(rows) + gap), top],
            "range": _settled_range(row, record),
        }
    figure.layout["xaxis"]["anchor"] = "y" if len(rows) == 1 else f"y{len(rows)}"
    return figure


def _shown_innovation(row: Innovation) -> Innovation:
    """Return an innovation in the unit in which people see its quantity."""
    scale = {"[cm]": CM, "[kN]": KN}.get(INNOVATIONS.get(row.name, ("", ""))[1], 1.0)
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
