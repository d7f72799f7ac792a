"""One page on what would have been: answers, what they stand on, and the motions one over the other."""

from __future__ import annotations

import html
from collections.abc import Sequence

from heave_bags.report.figure import CM, KN, RUN_COLOURS, UNCOMPENSATED, Figure, line
from heave_bags.report.report import place_figure, render_page
from heave_bags.signals import Signal
from heave_node.numerics.arrays import Array

from heave_bringup.whatif.answer import unit_motion
from heave_bringup.whatif.fitness import warnings
from heave_bringup.whatif.signals.record import without_move
from heave_bringup.whatif.words import Result, causes, check_line, headings, identified_rows, report_line, rows

FOOTER = (
    "Bands are of 90 %: the plants that the record allows, and the error of the twins. Motions are about their mean."
)


def render(title: str, result: Result) -> str:
    """Return the page with a `title` on a `result`, as HTML that opens offline."""
    figures: list[Figure] = []
    notices = [*warnings(result.known, result.answers), *causes(result.answers)]
    body = [
        f"<h1>{html.escape(title)}</h1>",
        '<p class="lead">What another law, gain or winch would have done in the sea of this record</p>',
        f"<p>{html.escape(check_line(result))}</p>",
        f"<p>{html.escape(report_line(result.known))}</p>",
        *(f'<p class="notice">{html.escape(one)}</p>' for one in notices),
        "<h2>Answers</h2>",
        _table(headings(), rows(result)),
        "<h2>Motions</h2>",
        *(place_figure(one, figures) for one in (_unit(result), _payout(result), _tension(result))),
        "<h2>Identified</h2>",
        _table(["quantity", "value", "sigma", "assumed"], identified_rows(result.known)),
    ]
    return render_page(title, "\n".join(body), figures, footer=FOOTER)


def _table(columns: Sequence[str], cells: Sequence[Sequence[str]]) -> str:
    head = "".join(f"<th>{html.escape(one)}</th>" for one in columns)
    lines = "".join("<tr>" + "".join(f"<td>{html.escape(one)}</td>" for one in row) + "</tr>" for row in cells)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{lines}</tbody></table>"


def _over_time(title: str, caption: str, axis: str, drawn: Sequence[tuple[str, Array]], time: Array) -> Figure:
    """Return a figure of motions over time, the record first."""
    colours = (UNCOMPENSATED, *RUN_COLOURS)
    traces = [
        line(Signal(time, values), name, colours[number % len(colours)]) for number, (name, values) in enumerate(drawn)
    ]
    layout = {"xaxis": {"title": {"text": "simulated time [s]"}}, "yaxis": {"title": {"text": axis}}}
    return Figure(title, caption, traces, layout)


def _unit(result: Result) -> Figure:
    known = result.known
    was = known.past.plant.unit + known.set_point + known.unexplained.heave
    drawn = [
        ("recorded", without_move(known.past.record.time, was, known.set_point)),
        *((one.asked.name, unit_motion(one.done, known.unexplained_in(one.done.payout))) for one in result.answers),
    ]
    moved = [(name, CM * (values - values.mean())) for name, values in drawn]
    return _over_time("Heave of the unit", "About its mean depth.", "heave [cm]", moved, known.past.record.time)


def _payout(result: Result) -> Figure:
    known = result.known
    drawn = [("recorded", known.past.winch.payout), *((one.asked.name, one.done.payout) for one in result.answers)]
    moved = [(name, CM * values) for name, values in drawn]
    return _over_time("Payout", "Positive pays out.", "payout [cm]", moved, known.past.record.time)


def _tension(result: Result) -> Figure:
    known = result.known
    drawn = [("recorded", known.past.plant.tension), *((one.asked.name, one.done.tension) for one in result.answers)]
    moved = [(name, KN * values) for name, values in drawn]
    return _over_time("Top tension", "Of the twins.", "tension [kN]", moved, known.past.record.time)
