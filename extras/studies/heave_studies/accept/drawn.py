"""What is drawn of a step of an acceptance test, and how a criterion is written."""

from __future__ import annotations

import math
from collections.abc import Sequence

from heave_bags.analyse.verdict import Judged, required_words
from heave_bags.report.figure import BOOM_TIP, CM, KN, PAYOUT, UNCOMPENSATED, UNIT, Figure, line
from heave_bags.signals import Signal

from heave_studies.accept.measured import Measured


def cells(judged: Judged) -> tuple[str, str, str]:
    """Return title, required and reached of a criterion that was `judged`."""
    definition = judged.definition
    title = definition.title if definition else judged.criterion.kpi
    return title, required_words(judged.criterion, judged.known), judged.got


def figures_of(one: Measured) -> list[Figure]:
    """Return the figures of what a step left: `one`."""
    run, ordered = one.run, one.ordered_rate
    rates = [("measured", run.payout_rate, PAYOUT), ("ordered", ordered, UNCOMPENSATED)]
    motions = [
        ("boom tip", run.boom_tip_heave, BOOM_TIP),
        ("payout", run.payout, PAYOUT),
        ("unit, off", run.uncompensated_heave, UNCOMPENSATED),
        ("unit", run.unit_heave, UNIT),
    ]
    found = [_drawn(one, "Payout rate", "payout rate [m/s]", rates, 1.0)] if ordered.value.any() else []
    if run.boom_tip_heave.size or run.unit_heave.size:
        about = [(name, Signal(of.time, of.value - of.value.mean()) if of.size else of, c) for name, of, c in motions]
        found.append(_drawn(one, "Motions about their means", "motion [cm]", about, CM))
        if run.tension.size:
            found.append(_drawn(one, "Top tension", "tension [kN]", [("tension", run.tension, UNIT)], KN))
    elif run.payout.size and not found:
        found.append(_drawn(one, "Payout", "payout [m]", [("payout", run.payout, PAYOUT)], 1.0))
    return found


def _drawn(
    measured: Measured, title: str, axis: str, traces: Sequence[tuple[str, Signal, str]], scale: float
) -> Figure:
    lines = [line(Signal(of.time, scale * of.value), name, colour) for name, of, colour in traces if of.size]
    shapes = [
        {"type": "line", "x0": at, "x1": at, "yref": "paper", "y0": 0, "y1": 1, "line": {"dash": "dot", "width": 1}}
        for at in (measured.event, measured.stop)
        if math.isfinite(at)
    ]
    layout = {"xaxis": {"title": {"text": "time [s]"}}, "yaxis": {"title": {"text": axis}}, "shapes": shapes}
    caption = "Dotted: the event, and the drum at rest." if shapes else ""
    return Figure(title, caption, lines, layout, height=260, is_over_time=False)
