"""The report of an acceptance test: one HTML file that opens offline and prints on A4, to be signed."""

from __future__ import annotations

import html
import math
from collections.abc import Sequence

from heave_bags.analyse.kpi_set import DEFINITION_OF
from heave_bags.analyse.verdict import FAILED, PASSED, Judged, required_words
from heave_bags.report.figure import BOOM_TIP, CM, KN, PAYOUT, UNCOMPENSATED, UNIT, Figure, line
from heave_bags.report.parts import notice, table
from heave_bags.report.report import place_figure, render_page, unbroken
from heave_bags.signals import Signal

from heave_studies.accept.figures import RESIDUALS
from heave_studies.accept.results import Acceptance, StepResult

FOOTER = (
    "Figures are of the time that is judged. Outlet: what the winch leaves of the boom tip's heave. Residuals are "
    "standard deviations. A figure that is not known is not met."
)
_EMPTY_LINE = '<td style="height:2.6rem;min-width:10rem"></td>'


def render(found: Acceptance) -> str:
    """Return the page of an acceptance test that was `found`, as HTML."""
    drawn: list[Figure] = []
    procedure = found.procedure
    verdict = PASSED if found.is_passed else FAILED
    body = [
        f"<h1>{html.escape(procedure.title)}</h1>",
        f'<p class="lead">{html.escape(procedure.description)}</p>',
        _verdict(found, verdict),
        f"<h2>Steps</h2>{table(*summary(found.results), texts=5)}",
        _residuals(found.results),
        *(_step(number, one, drawn) for number, one in enumerate(found.results, 1)),
        f"<h2>What was tested, and with what</h2>{table(['', ''], _facts(found), texts=2)}",
        _signatures(procedure.signatures),
    ]
    return render_page(procedure.title, "\n".join(body), drawn, footer=FOOTER)


def _verdict(found: Acceptance, verdict: str) -> str:
    passed = sum(one.state == PASSED for one in found.results)
    kind = "good" if found.is_passed else "bad"
    lines = "".join(f"<li>{html.escape(unbroken(words))}</li>" for words in found.failures)
    head = f"<strong>{html.escape(verdict)}</strong>: {passed} of {len(found.results)} steps passed"
    return f'<div class="verdict {kind}">{head}<ul>{lines}</ul></div>'


def summary(results: Sequence[StepResult]) -> tuple[list[str], list[list[str]]]:
    """Return head and rows of the table of steps, of their `results`."""
    head = ["step", "verdict", "required", "reached", "against"]
    rows = []
    for one in results:
        for place, judged in enumerate(one.judged or (None,)):
            title, required, got = ("", "", one.failure) if judged is None else cells(judged)
            name, state, part = (one.step.name, one.state, one.part) if place == 0 else ("", "", "")
            rows.append([name, state, unbroken(f"{title}: {required}".strip(": ")), unbroken(got), part])
    return head, rows


def cells(judged: Judged) -> tuple[str, str, str]:
    """Return title, required and reached of a criterion that was `judged`."""
    definition = judged.definition
    title = definition.title if definition else judged.criterion.kpi
    return title, required_words(judged.criterion, judged.known), judged.got


def residual_rows(results: Sequence[StepResult]) -> tuple[list[str], list[list[str]]]:
    """Return head and rows of the four residuals of the steps, of their `results`, that have one."""
    definitions = [DEFINITION_OF[key] for key in RESIDUALS]
    head = ["step", *(f"{one.title} [{one.unit}]" for one in definitions)]
    rows = [
        [one.step.name, *(of.text(one.values.get(of.key, math.nan)) for of in definitions)]
        for one in results
        if any(math.isfinite(one.values.get(key, math.nan)) for key in RESIDUALS[:2])
    ]
    return head, rows


def _residuals(results: Sequence[StepResult]) -> str:
    head, rows = residual_rows(results)
    caption = '<p class="caption">The definitions in use, side by side: compare like with like.</p>'
    return f"<h2>Residuals</h2>{caption}{table(head, rows, texts=1)}" if rows else ""


def _step(number: int, one: StepResult, drawn: list[Figure]) -> str:
    step = one.step
    parts = [f"<h2>{number}. {html.escape(step.name)}: {html.escape(one.state)}</h2>"]
    if step.what:
        parts.append(f'<p class="lead">{html.escape(step.what)}</p>')
    signal = getattr(step.test, "signal", None)
    done = [signal.words if signal else "", f"event: {step.event.words}" if step.event else "", *one.breaches]
    parts += [f'<p class="caption">{html.escape(words)}</p>' for words in done if words]
    if one.failure:
        parts.append(notice(one.failure))
    if one.judged:
        rows = [[*cells(judged), "met" if judged.is_met else "FAILED"] for judged in one.judged]
        parts.append(table(["figure", "required", "reached", "verdict"], rows, texts=4))
    if one.measured is not None:
        parts += [notice(words) for words in one.measured.notes]
        parts += [place_figure(figure, drawn) for figure in _figures(one)]
    return "\n".join(parts)


def _figures(one: StepResult) -> list[Figure]:
    assert one.measured is not None
    run, ordered = one.measured.run, one.measured.ordered_rate
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


def _drawn(one: StepResult, title: str, axis: str, traces: Sequence[tuple[str, Signal, str]], scale: float) -> Figure:
    measured = one.measured
    assert measured is not None
    lines = [line(Signal(of.time, scale * of.value), name, colour) for name, of, colour in traces if of.size]
    shapes = [
        {"type": "line", "x0": at, "x1": at, "yref": "paper", "y0": 0, "y1": 1, "line": {"dash": "dot", "width": 1}}
        for at in (measured.event, measured.stop)
        if math.isfinite(at)
    ]
    layout = {"xaxis": {"title": {"text": "time [s]"}}, "yaxis": {"title": {"text": axis}}, "shapes": shapes}
    caption = "Dotted: the event, and the drum at rest." if shapes else ""
    return Figure(title, caption, lines, layout, height=260, is_over_time=False)


def _facts(found: Acceptance) -> list[list[str]]:
    files = [[f"record of step {number}", f"{one.file.name}, SHA-256 {one.digest}"]
             for number, one in enumerate(found.results, 1) if one.file is not None]  # fmt: skip
    return [*([name, words] for name, words in {**found.parts, **found.facts}.items()), *files]


def _signatures(names: Sequence[str]) -> str:
    if not names:
        return ""
    head = "".join(f"<th>{words}</th>" for words in ("for", "name", "date and place", "signature"))
    rows = "".join(f"<tr><td>{html.escape(name)}</td>{_EMPTY_LINE * 3}</tr>" for name in names)
    return f'<h2>Signatures</h2><table style="width:100%"><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>'
