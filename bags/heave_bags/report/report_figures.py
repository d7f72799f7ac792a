"""The figures of a report as plain data for plotly.js: arrays travel packed, and the page thins them to what a
screen can show.
"""

from __future__ import annotations

import base64
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.tick.durations import EDGES, LAST

from heave_bags.analyse import events
from heave_bags.analyse.events import Interval
from heave_bags.analyse.kpi_set import QUANTITIES
from heave_bags.analyse.run_record import Innovation, RunRecord
from heave_bags.analyse.spectra import Spectrum, spectrum, transmissibility
from heave_bags.signals import Signal

BOOM_TIP = "#0072b2"
PAYOUT = "#e69f00"
UNIT = "#009e73"
UNCOMPENSATED = "#999999"
LIMIT = "#d55e00"
OTHER = "#cc79a7"
AT_LIMIT = "#8c564b"
RUN_COLOURS = ("#009e73", "#0072b2", "#e69f00", "#cc79a7", "#56b4e9", "#d55e00", "#8c564b")
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

TRANSIENT = "rgba(136, 136, 136, 0.2)"
"""The time that no figure counts."""
MOST_MODES = 12
"""Modes or limits that a legend names; a bag may bring any number."""

CM, KN = QUANTITIES["m"][1], QUANTITIES["N"][1]
"""Motions [cm] and forces [kN] as people see them, over their SI units."""

LABEL_HEIGHT = 18.0
"""Distance from one name of a trace to the next [pixels]."""

MAXIMUM_SAMPLES = 200_000
"""Largest number of samples of a signal in the page: longer ones are thinned, and their extremes stay."""
_TIME_TITLE = "simulated time [s]"


@dataclass
class Figure:
    """One figure. Figures over time zoom together.

    Attributes
    ----------
    title, caption : its name, and a line that explains it
    traces, layout : of plotly
    is_over_time : its x axis is the time of the run
    height : on the page [pixels]
    legend : names with the colours that mean them, below the caption: of what has no name beside its trace
    """

    title: str
    caption: str
    traces: list[dict[str, Any]] = field(default_factory=list)
    layout: dict[str, Any] = field(default_factory=dict)
    is_over_time: bool = True
    height: int = 380
    legend: list[tuple[str, str]] = field(default_factory=list)

    def to_mapping(self) -> dict[str, Any]:
        """Return what the page's script draws: hovering says units, and names stand beside what they name."""
        traces = [self._with_hover(trace) for trace in self.traces]
        drawn = {"traces": traces, "layout": self.layout, "labels": self._labels()}
        return {**drawn, "time": self.is_over_time, "height": self.height}

    def _axis(self, trace: Mapping[str, Any]) -> dict[str, Any]:
        axis: dict[str, Any] = self.layout.get(f"yaxis{trace.get('yaxis', 'y')[1:]}", {})
        return axis

    def _with_hover(self, trace: dict[str, Any]) -> dict[str, Any]:
        title = self._axis(trace).get("title", {}).get("text", "")
        return trace if "hovertemplate" in trace else {**trace, "hovertemplate": _hover(title)}

    def _labels(self) -> list[dict[str, Any]]:
        """Return the names of the traces as they stand at the right of their axes, from the top down."""
        named: dict[str, list[dict[str, Any]]] = {}
        for trace in self.traces:
            if trace.get("showlegend", True) and trace.get("mode") == "lines":
                named.setdefault(trace.get("yaxis", "y"), []).append(trace)
        found = []
        for traces in named.values():
            bottom, top = self._axis(traces[0]).get("domain", (0.0, 1.0))
            middle, step = 0.5 * (bottom + top), LABEL_HEIGHT / max(self.height - 55.0, 1.0)
            first = middle + 0.5 * step * (len(traces) - 1)
            found += [
                {"text": trace["name"], "y": first - number * step, "color": trace["line"]["color"]}
                for number, trace in enumerate(traces)
            ]
        return found


def without_nan(value: Any) -> Any:
    """Return the plain data `value` with None in place of NaN and infinity: JSON knows neither NaN nor infinity."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {name: without_nan(item) for name, item in value.items()}
    return [without_nan(item) for item in value] if isinstance(value, list | tuple) else value


def pack(values: Array) -> dict[str, Any]:
    """Return `values`, shape (n,), as the page's script unpacks them.

    Even steps are three numbers, others 32-bit floats about an offset.
    """
    if values.size > 2:
        step = (values[-1] - values[0]) / (values.size - 1)
        even = values[0] + step * np.arange(values.size)
        if step > 0.0 and np.abs(even - values).max() < 1e-6 * step:
            return {"start": float(values[0]), "step": float(step), "count": int(values.size)}
    offset = float(values[0]) if values.size and math.isfinite(values[0]) else 0.0
    data = (values - offset).astype("<f4").tobytes()
    return {"offset": offset, "float32": base64.b64encode(data).decode("ascii")}


def thin(signal: Signal, limit: int = MAXIMUM_SAMPLES) -> Signal:
    """Return at most `limit` samples of `signal`: of each stretch of time the smallest and the largest.

    So no peak is lost.
    """
    if signal.size <= limit:
        return signal
    bounds = np.linspace(0, signal.size, limit // 2 + 1).astype(int)
    kept: list[int] = []
    for first, after in pairwise(bounds):
        part = signal.value[first:after]
        kept += sorted({first + int(part.argmin()), first + int(part.argmax())})
    return Signal(signal.time[kept], signal.value[kept])


def line(signal: Signal, name: str, colour: str, **style: Any) -> dict[str, Any]:
    """Return `signal` as a line with a `name` and `colour`; `style`: `axis` ("y2"), `dash`, `width`, `opacity`."""
    small = thin(signal)
    trace: dict[str, Any] = {
        "name": name,
        "x": pack(small.time),
        "y": pack(small.value),
        "mode": "lines",
        "line": {"color": colour, "width": style.get("width", 1.3), "dash": style.get("dash", "solid")},
        "opacity": style.get("opacity", 1.0),
    }
    if "axis" in style:
        trace["yaxis"] = style["axis"]
    return trace


def _about_mean(signal: Signal) -> Signal:
    """Return a motion about its mean as people see motions [cm]."""
    return Signal(signal.time, CM * (signal.value - signal.value.mean())) if signal.size else signal


def _hover(axis_title: str) -> str:
    """Return what a trace says under the pointer: its value in the unit of its axis."""
    unit = axis_title[axis_title.rfind("[") + 1 :].rstrip("]") if "[" in axis_title else ""
    return f"%{{y:.4~g}} {unit}".rstrip()


def _level(height: float, name: str, axis: str = "y") -> list[dict[str, Any]]:
    """Return a horizontal line with its name, for a limit; nothing for one that is not known."""
    if not math.isfinite(height):
        return []
    return [
        {
            "type": "line",
            "xref": "paper",
            "x0": 0,
            "x1": 1,
            "yref": axis,
            "y0": height,
            "y1": height,
            "line": {"color": LIMIT, "width": 1.2, "dash": "dash"},
            "label": {"text": name, "textposition": "start", "font": {"size": 10, "color": LIMIT}},
        }
    ]


def _transient(record: RunRecord) -> list[dict[str, Any]]:
    """Return a grey band over the time that no figure counts."""
    first = record.signals.unit_heave.time[0] if record.signals.unit_heave.size else 0.0
    if record.start <= first:
        return []
    return [
        {
            "type": "rect",
            "xref": "x",
            "x0": float(first),
            "x1": record.start,
            "yref": "paper",
            "y0": 0,
            "y1": 1,
            "fillcolor": TRANSIENT,
            "line": {"width": 0},
            "layer": "below",
        }
    ]


def _time_layout(record: RunRecord, y_title: str, shapes: Sequence[dict[str, Any]] = ()) -> dict[str, Any]:
    return {
        "xaxis": {"title": {"text": _TIME_TITLE}},
        "yaxis": {"title": {"text": y_title}},
        "shapes": [*_transient(record), *shapes],
    }


def _ribbon(intervals: Sequence[Interval], row: str, colour: str, name: str) -> dict[str, Any]:
    """Return intervals as a thick line in the row `row` of the ribbon."""
    x: list[float | None] = []
    y: list[str | None] = []
    texts: list[str | None] = []
    for interval in intervals:
        x += [interval.start, interval.end, None]
        y += [row, row, None]
        texts += [interval.name, interval.name, None]
    return {
        "name": name,
        "x": x,
        "y": y,
        "text": texts,
        "mode": "lines",
        "line": {"color": colour, "width": 13},
        "hovertemplate": "%{text}: %{x:.1f} s<extra></extra>",
        "yaxis": "y2",
        "showlegend": False,
    }


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
    return [*found, *([("transient, not counted", TRANSIENT)] if _transient(record) else [])]


def motion_figure(record: RunRecord) -> Figure:
    """Boom tip, minus payout and unit about their means, below the ribbon of modes, limits and alarms of `record`."""
    signals = record.signals
    minus_payout = Signal(signals.payout.time, -signals.payout.value)
    ribbon = ribbon_traces(record)
    figure = Figure(
        "Motion",
        "Heave about the mean: boom tip plus minus payout is the motion of the cable's top. "
        "Above: mode of the controller, brake, active winch limits and alarms, in the colours below.",
        layout=_time_layout(record, "heave about the mean [cm]"),
        height=480,
    )
    figure.traces += [
        line(_about_mean(signals.boom_tip_heave), "boom tip", BOOM_TIP),
        line(_about_mean(minus_payout), "minus payout", PAYOUT),
        line(_about_mean(signals.unit_heave), "unit", UNIT, width=1.8),
    ]
    figure.legend = ribbon_legend(record)
    if ribbon:
        rows = [row for row in ("alarms", "limits", "brake", "mode") if any(trace["y"][0] == row for trace in ribbon)]
        figure.traces += ribbon
        figure.layout["yaxis"]["domain"] = [0.0, 0.78]
        figure.layout["yaxis2"] = {
            "domain": [0.82, 1.0],
            "type": "category",
            "categoryorder": "array",
            "categoryarray": rows,
            "fixedrange": True,
            "showgrid": False,
        }
    return figure


def unit_figure(record: RunRecord) -> Figure:
    """Unit heave with and without compensation, of the run `record`."""
    signals = record.signals
    figure = Figure(
        "Unit heave, compensated and uncompensated",
        "Uncompensated: the same sea and cable with the winch locked, computed beside the run.",
        layout=_time_layout(record, "unit heave about the mean [cm]"),
    )
    figure.traces += [
        line(_about_mean(signals.uncompensated_heave), "uncompensated", UNCOMPENSATED),
        line(_about_mean(signals.unit_heave), "compensated", UNIT, width=1.6),
    ]
    return figure


def tension_figure(record: RunRecord) -> Figure:
    """Top tension of the run `record` with its static value, slack and snap limits.

    The static value is a line where the deployed length changes.
    """
    static = record.signals.static_tension
    tension = record.signals.tension
    is_steady = static.size == 1
    shapes = _level(0.0, "slack")
    for share, name in ((1.0, "static"), (1.3, "1.3 static"), (0.1, "0.1 static")) if is_steady else ():
        shapes += _level(share * static.value[0] * KN, name)
    figure = Figure(
        "Top tension",
        "A snap is a tension below 0.1 of the static one followed by more than 1.3 of it within 2 s.",
        layout=_time_layout(record, "top tension [kN]", shapes),
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
    shapes = [shape for sign in (1, -1) for shape in _level(sign * signals.speed_limit, "speed limit")]
    for sign in (1, -1):
        shapes += _level(sign * signals.acceleration_limit, "acceleration limit", "y2")
    learnt = [*_identified_limit(record, "speed", "y"), *_identified_limit(record, "acceleration", "y2")]
    figure = Figure(
        "Winch speed and acceleration",
        "Positive pays out and lowers the unit. Dashed: limits of the winch as stated"
        + ("; dotted: limits that the controller has identified, from when it reported them." if learnt else "."),
        layout=_time_layout(record, "payout rate [m/s]", shapes),
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
    """Return a limit of the winch that was learnt in the run `record` as two lines, in steps; nothing where none was.

    Parameters
    ----------
    record : of the run
    quantity : speed or acceleration
    axis : of the figure
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


def spectrum_lines(record: RunRecord) -> dict[str, Spectrum]:
    """Return the spectra of the evaluation window of the run `record` by name.

    Those that cannot be computed are left out.
    """
    signals = record.signals
    named = {
        "boom tip": signals.boom_tip_heave,
        "uncompensated": signals.uncompensated_heave,
        "unit": signals.unit_heave,
    }
    spectra = {name: spectrum(signal.window(record.start, record.end)) for name, signal in named.items()}
    return {name: found for name, found in spectra.items() if found is not None}


def _spectrum_line(shown: Spectrum, name: str, colour: str, **style: Any) -> dict[str, Any]:
    visible = shown.omega <= HIGHEST_OMEGA
    return line(Signal(shown.omega[visible], shown.density[visible]), name, colour, **style)


def _density_line(shown: Spectrum, name: str, colour: str) -> dict[str, Any]:
    return _spectrum_line(Spectrum(shown.omega, CM**2 * shown.density), name, colour)


HIGHEST_OMEGA = 4.0
"""Spectra are in the page up to this angular frequency [rad/s]; a sea has nothing above it."""
SHOWN_OMEGA = 2.5
"""Spectra are shown up to this angular frequency [rad/s] before anyone zooms."""
SCALED_FLOOR = 1e-2
"""Share of the boom tip's peak density above which a transmissibility is shown: below, it divides noise by noise."""


def _decades(pairs: Sequence[tuple[Spectrum, Spectrum]]) -> float:
    """Return how many decades the densities that are shown span."""
    shown = [one.density[(one.omega <= SHOWN_OMEGA) & (one.density > 0.0)] for pair in pairs for one in pair]
    values = np.concatenate(shown) if shown else np.empty(0)
    return float(np.log10(values.max() / values.min())) if values.size else 1.0


def _spectrum_layout(pairs: Sequence[tuple[Spectrum, Spectrum]]) -> dict[str, Any]:
    """Return the layout for transmissibilities of `pairs` (unit, boom tip), scaled to what is shown and moves much."""
    ratios = [transmissibility(unit, boom_tip, SCALED_FLOOR) for unit, boom_tip in pairs]
    shown = [ratio.density[ratio.omega <= SHOWN_OMEGA] for ratio in ratios]
    reach = 1.15 * max((float(values.max()) for values in shown if values.size), default=1.0)
    return {
        "xaxis": {"title": {"text": "angular frequency ω [rad/s]"}, "range": [0.0, SHOWN_OMEGA]},
        "yaxis": {
            "title": {"text": "S(ω) [cm² s/rad]"},
            "type": "log",
            "exponentformat": "power",
            "dtick": max(1, math.ceil(_decades(pairs) / 5.0)),
            "domain": [0.54, 1.0],
        },
        "yaxis2": {"title": {"text": "transmissibility [-]"}, "domain": [0.0, 0.46], "range": [0.0, reach]},
    }


def spectrum_figure(record: RunRecord) -> Figure:
    """Spectra of boom tip and unit, and the transmissibility with and without compensation, of the run `record`."""
    spectra = spectrum_lines(record)
    compared = [name for name in ("uncompensated", "unit") if {name, "boom tip"} <= set(spectra)]
    figure = Figure(
        "Spectra and transmissibility",
        "One-sided spectra over angular frequency (Welch). Transmissibility √(S_unit/S_boom tip), "
        "where the boom tip has at least a hundredth of its peak density.",
        layout=_spectrum_layout([(spectra[name], spectra["boom tip"]) for name in compared]),
        is_over_time=False,
        height=560,
    )
    figure.layout["xaxis"]["anchor"] = "y2"
    colours = {"boom tip": BOOM_TIP, "uncompensated": UNCOMPENSATED, "unit": UNIT}
    labels = {"unit": "compensated"}
    for name, found in spectra.items():
        figure.traces.append(_density_line(found, labels.get(name, name), colours[name]))
    for name in compared:
        ratio = transmissibility(spectra[name], spectra["boom tip"], SCALED_FLOOR)
        figure.traces.append(_spectrum_line(ratio, labels.get(name, name), colours[name], axis="y2"))
    return figure


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
        "Measurement minus prediction; dotted: two predicted standard deviations, which 95 % should keep within.",
        layout=_time_layout(record, ""),
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
    """Return the range that the evaluation window needs: the first innovations of a filter dwarf all others."""
    settled = (row.time >= record.start) & (row.time <= record.end)
    shown = settled if settled.any() else np.ones(row.time.size, dtype=bool)
    reach = 1.15 * max(float(np.abs(row.value[shown]).max()), float(2.0 * row.sigma[shown].max()), 1e-9)
    return [-reach, reach]


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
    heave = Figure(
        "Unit heave of all runs",
        "About the mean of each run. Grey: transient, not counted.",
        layout=_time_layout(records[0], "unit heave about the mean [cm]"),
    )
    found_of = [spectrum_lines(record) for record in records]
    pairs = [(found["unit"], found["boom tip"]) for found in found_of if {"unit", "boom tip"} <= set(found)]
    spectra = Figure(
        "Spectra and transmissibility of all runs",
        "Of the unit; the transmissibility where the boom tip has at least a hundredth of its peak density.",
        layout=_spectrum_layout(pairs),
        is_over_time=False,
        height=560,
    )
    spectra.layout["xaxis"]["anchor"] = "y2"
    for index, (record, found, label) in enumerate(zip(records, found_of, names, strict=True)):
        colour = RUN_COLOURS[index % len(RUN_COLOURS)]
        heave.traces.append(line(_about_mean(record.signals.unit_heave), label, colour))
        if "unit" in found:
            spectra.traces.append(_density_line(found["unit"], label, colour))
        if {"unit", "boom tip"} <= set(found):
            ratio = transmissibility(found["unit"], found["boom tip"], SCALED_FLOOR)
            spectra.traces.append(_spectrum_line(ratio, label, colour, axis="y2"))
    return [heave, spectra]
