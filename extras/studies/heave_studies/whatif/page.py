"""One page on what would have been: answers, what they stand on, and the motions one over the other."""

from __future__ import annotations

import html
from collections.abc import Sequence

from heave_bags.report.figure import CM, KN, RUN_COLOURS, UNCOMPENSATED, UNCOUNTED, Figure, line, uncounted_band
from heave_bags.report.parts import notice, table
from heave_bags.report.report import place_figure, render_page
from heave_bags.signals import Signal
from heave_node.numerics.arrays import Array

from heave_studies.whatif.answer import unit_motion
from heave_studies.whatif.known import Known
from heave_studies.whatif.signals.record import without_move
from heave_studies.whatif.words import (
    EXPERIMENTAL,
    IDENTIFIED,
    Result,
    causes,
    headings,
    identified_rows,
    lines_before,
    rows,
)

RECORDED_WIDTH = 4.0
"""Of the line of the record, which others cover where they do the same [pixels]."""

FOOTER = (
    "Bands are of 90 %: the plants that the record allows, and the error of the twins. Motions are about their mean."
)


def render(title: str, result: Result) -> str:
    """Return the page with a `title` on a `result`, as HTML that opens offline."""
    figures: list[Figure] = []
    notices = [EXPERIMENTAL, *result.warnings, *causes(result.answers)]
    body = [
        f"<h1>{html.escape(title)}</h1>",
        '<p class="lead">What another law, gain or winch would have done in the sea of this record</p>',
        *(f"<p>{html.escape(one)}</p>" for one in lines_before(result)),
        *map(notice, notices),
        "<h2>Answers</h2>",
        table(headings(), rows(result), texts=1),
        "<h2>Motions</h2>",
        *(place_figure(one, figures) for one in (_unit(result), _payout(result), _tension(result))),
        "<h2>Identified</h2>",
        table(IDENTIFIED, identified_rows(result.known), texts=1, last_is_text=True),
    ]
    return render_page(title, "\n".join(body), figures, footer=FOOTER)


def _over_time(title: str, caption: str, axis: str, drawn: Sequence[tuple[str, Array]], known: Known) -> Figure:
    """Return a figure of motions over the time of what is `known`, the record first: wide, under the others."""
    time, colours = known.past.record.time, (UNCOMPENSATED, *RUN_COLOURS)
    traces = [
        line(Signal(time, values), name, colours[number % len(colours)], width=1.3 if number else RECORDED_WIDTH)
        for number, (name, values) in enumerate(drawn)
    ]
    transient = uncounted_band(float(time[0]), float(time[known.window.start]))
    layout = {
        "xaxis": {"title": {"text": "time of the record [s]"}},
        "yaxis": {"title": {"text": axis}},
        "shapes": transient,
    }
    return Figure(title, caption, traces, layout, legend=[UNCOUNTED] if transient else [])


def _unit(result: Result) -> Figure:
    known = result.known
    was = known.past.plant.unit + known.set_point + known.unexplained.heave
    drawn = [
        ("recorded", without_move(known.past.record.time, was, known.set_point)),
        *((one.asked.name, unit_motion(one.done, known.unexplained_in(one.done.payout))) for one in result.answers),
    ]
    moved = [(name, CM * (values - values.mean())) for name, values in drawn]
    return _over_time("Heave of the unit", "About its mean depth.", "heave [cm]", moved, known)


def _payout(result: Result) -> Figure:
    known = result.known
    drawn = [("recorded", known.past.winch.payout), *((one.asked.name, one.done.payout) for one in result.answers)]
    moved = [(name, CM * values) for name, values in drawn]
    return _over_time("Payout", "Positive pays out.", "payout [cm]", moved, known)


def _tension(result: Result) -> Figure:
    known = result.known
    drawn = [("recorded", known.past.plant.tension), *((one.asked.name, one.done.tension) for one in result.answers)]
    moved = [(name, KN * values) for name, values in drawn]
    return _over_time("Top tension", "Of the twins.", "tension [kN]", moved, known)
