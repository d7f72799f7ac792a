"""A figure of a report as plain data for plotly.js: arrays travel packed, and are thinned to what a screen can show."""

from __future__ import annotations

import base64
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from heave_node.numerics.arrays import Array

from heave_bags.analyse.kpis.definition import QUANTITIES
from heave_bags.analyse.run_record import RunRecord
from heave_bags.signals import Signal

BOOM_TIP = "#0072b2"
PAYOUT = "#e69f00"
UNIT = "#009e73"
UNCOMPENSATED = "#999999"
LIMIT = "#d55e00"
OTHER = "#cc79a7"
RUN_COLOURS = ("#009e73", "#0072b2", "#e69f00", "#cc79a7", "#56b4e9", "#d55e00", "#8c564b")
TRANSIENT = "rgba(136, 136, 136, 0.2)"
"""The time that no figure counts."""
UNCOUNTED = ("transient, not counted", TRANSIENT)
"""Its entry in a legend."""
CM, KN = QUANTITIES["m"][1], QUANTITIES["N"][1]
"""Motions [cm] and forces [kN] as people see them, over their SI units."""
LABEL_HEIGHT = 18.0
"""Distance from one name of a trace to the next [pixels]."""
MAXIMUM_SAMPLES = 200_000
"""Largest number of samples of a signal in the page: longer ones are thinned, and their extremes stay."""


@dataclass
class Figure:
    """One figure. Figures over time zoom together."""

    title: str  # its name
    caption: str  # a line that explains it
    traces: list[dict[str, Any]] = field(default_factory=list)  # of plotly
    layout: dict[str, Any] = field(default_factory=dict)  # of plotly
    is_over_time: bool = True  # its x axis is the time of the run
    height: int = 380  # on the page [pixels]
    # names with the colours that mean them, below the caption: of what has no name beside its trace
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


def about_mean(signal: Signal) -> Signal:
    """Return a motion, `signal` [m], about its mean as people see motions [cm]."""
    return Signal(signal.time, CM * (signal.value - signal.value.mean())) if signal.size else signal


def _hover(axis_title: str) -> str:
    """Return what a trace says under the pointer: its value in the unit of its axis."""
    unit = axis_title[axis_title.rfind("[") + 1 :].rstrip("]") if "[" in axis_title else ""
    return f"%{{y:.4~g}} {unit}".rstrip()


def limit_line(height: float, name: str, axis: str = "y") -> list[dict[str, Any]]:
    """Return a limit as a line at a `height` of an `axis` with its `name`; nothing for one that is not known."""
    if not math.isfinite(height):
        return []
    place = {"type": "line", "xref": "paper", "x0": 0, "x1": 1, "yref": axis, "y0": height, "y1": height}
    label = {"text": name, "textposition": "start", "font": {"size": 10, "color": LIMIT}}
    return [{**place, "line": {"color": LIMIT, "width": 1.2, "dash": "dash"}, "label": label}]


def transient_band(record: RunRecord) -> list[dict[str, Any]]:
    """Return a grey band over the time of the run `record` that no figure counts."""
    first = record.signals.unit_heave.time[0] if record.signals.unit_heave.size else 0.0
    return uncounted_band(float(first), record.start)


def uncounted_band(first: float, start: float) -> list[dict[str, Any]]:
    """Return a grey band from a `first` time to the `start` of what figures count [s]; none where they count all."""
    if start <= first:
        return []
    place = {"type": "rect", "xref": "x", "x0": first, "x1": start, "yref": "paper", "y0": 0, "y1": 1}
    return [{**place, "fillcolor": TRANSIENT, "line": {"width": 0}, "layer": "below"}]


def time_layout(record: RunRecord, y_title: str, shapes: Sequence[dict[str, Any]] = ()) -> dict[str, Any]:
    """Return the layout of a figure over the time of `record`, with `shapes` beside the band of the transient.

    Its y axis has the title `y_title`.
    """
    return {
        "xaxis": {"title": {"text": "simulated time [s]"}},
        "yaxis": {"title": {"text": y_title}},
        "shapes": [*transient_band(record), *shapes],
    }
