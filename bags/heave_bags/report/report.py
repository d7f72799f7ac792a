"""The report of one or several runs: one HTML file that opens offline, zooms and prints."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from collections.abc import Mapping, Sequence
from importlib import resources
from pathlib import Path
from typing import Any

from heave_node.files.given_files import whole_file
from jinja2 import Environment, FunctionLoader, StrictUndefined, Template

from heave_bags.analyse import analysis, differences, kpi_set, run_warnings, run_words
from heave_bags.analyse.kpi_set import BESIDE, source_of
from heave_bags.analyse.run_record import RunRecord
from heave_bags.analyse.verdict import FAILED, NO_VERDICT, Verdict, judge
from heave_bags.report import headline
from heave_bags.report.figure import RUN_COLOURS, Figure, without_nan
from heave_bags.report.lift import lift_drawing
from heave_bags.report.report_figures import comparison_figures, run_figures

PLOTLY = "plotly-cartesian.min.js"
"""The script that draws the figures: plotly.js 4.1.1, its charts in two dimensions (MIT, plotly.LICENSE.txt)."""
MOST_HAPPENINGS = 60
"""Lines of what happened in a run; the bag has them all."""


def save_report(records: Sequence[RunRecord], output: Path, verdicts: Sequence[Verdict] = ()) -> None:
    """Write the report of the runs `records` to `output`, with their `verdicts`, or those of the bags' own criteria.

    Raises OSError if the file cannot be written.
    """
    text = render(records, verdicts)
    output.parent.mkdir(parents=True, exist_ok=True)
    with whole_file(output) as unfinished:
        unfinished.write_text(text, encoding="utf-8")


def render(records: Sequence[RunRecord], verdicts: Sequence[Verdict] = ()) -> str:
    """Return the report of `records` as HTML text; `verdicts` as for `save_report`."""
    figures: list[Figure] = []
    content = page_content(records, figures, verdicts)
    return _page("report.html", figures, **content)


def _page(name: str, figures: Sequence[Figure], *, motion: Mapping[str, Any] | None = None, **content: Any) -> str:
    """Return a page with the script that draws its figures, and that which moves its drawing, as HTML."""
    scripts = [_asset(PLOTLY), f"\n{_asset('report.js')}", *([f"\n{_asset('lift.js')}"] if motion else [])]
    return _template(name).render(
        **content,
        policy=security_policy(scripts),
        style=_asset("report.css"),
        scripts=scripts,
        figures=_as_script([figure.to_mapping() for figure in figures]),
        motion=_as_script(motion) if motion else "",
    )


def _asset(name: str) -> str:
    return (resources.files("heave_bags.report") / "report_assets" / name).read_text(encoding="utf-8")


def _template(name: str) -> Template:
    """Return a page; what both pages share is in page.html."""
    pages = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, loader=FunctionLoader(_asset))
    return pages.get_template(name)


def security_policy(scripts: Sequence[str]) -> str:
    """Return the content security policy of a page: it runs these scripts and no other, and loads nothing.

    Whatever a bag puts into the page, a browser will not run it.
    """
    digests = (hashlib.sha256(script.encode()).digest() for script in scripts)
    hashes = " ".join(f"'sha256-{base64.b64encode(digest).decode()}'" for digest in digests)
    return (
        f"default-src 'none'; script-src {hashes}; style-src 'unsafe-inline'; img-src data: blob:; "
        "base-uri 'none'; form-action 'none'"
    )


def _as_script(data: Any) -> str:
    """Return plain `data` as JSON that no text in it can end; what is not a number is null."""
    return json.dumps(without_nan(data), allow_nan=False).replace("<", "\\u003c")


def render_page(title: str, body: str, figures: Sequence[Figure], footer: str) -> str:
    """Return a page of another study as HTML, which opens offline, zooms and prints as a report of a run does.

    It has a `title`, a `body` of HTML with the places of the `figures` in order (`place_figure`), and a line at the
    end, `footer`.
    """
    return _page("study.html", figures, title=title, body=body, footer=footer)


def place_figure(figure: Figure, figures: list[Figure]) -> str:
    """Return the place of a `figure` in a page, as HTML, and add it to the `figures` that the script draws."""
    figures.append(figure)
    return _template("figure.html").render(figure=figure, number=len(figures) - 1)


def page_content(
    records: Sequence[RunRecord], figures: list[Figure], verdicts: Sequence[Verdict] = ()
) -> dict[str, Any]:
    """Return what the page of `records` says, with `verdicts` as for `save_report`; the `figures` that the page's
    script draws are added.
    """
    labels = differences.labels(records)
    lift = lift_drawing(records[0]) if len(records) == 1 else None
    judged = list(verdicts) or [judge(record, record.wanted, moves_winch=record.moves_winch) for record in records]
    values = [analysis.as_seen(record) for record in records]

    def places(drawn: Sequence[Figure]) -> list[str]:
        return [place_figure(figure, figures) for figure in drawn]

    own = [run_figures(record) for record in records]
    is_only = len(records) == 1
    first = places(own[0][:1] if is_only else comparison_figures(records, labels))
    runs = [
        {
            **_run(record, verdict, column),
            "label": label,
            "colour": RUN_COLOURS[number % len(RUN_COLOURS)],
            "places": places(drawn[1:] if is_only else drawn),
        }
        for number, (record, verdict, column, label, drawn) in enumerate(
            zip(records, judged, values, labels, own, strict=True)
        )
    ]
    for run in runs[1:]:  # what they have in common is said once
        run["description"] = run["description"] if run["description"] != runs[0]["description"] else ""
        run["facts"] = {name: text for name, text in run["facts"].items() if text != runs[0]["facts"].get(name)}
    return {
        "title": differences.title(records),
        "lift": lift,
        "motion": lift and lift["motion"],
        "runs": runs,
        "first_places": first,
        "differences": [] if is_only else differences.differences(records),
        "groups": _groups(values, [record.sources for record in records]),
        "beside": BESIDE,
    }


def _run(record: RunRecord, verdict: Verdict, values: Mapping[str, float]) -> dict[str, Any]:
    happenings = run_words.happenings(record)
    return {
        "name": record.name,
        "description": record.description,
        "facts": {name: unbroken(text) for name, text in run_words.facts(record).items()},
        "remarks": [*record.remarks(), *run_warnings.warnings(record, values)],
        "verdict": [unbroken(line.strip()) for line in verdict.lines()],
        "verdict_class": {FAILED: "bad", NO_VERDICT: ""}.get(verdict.state, "good"),
        "tiles": _tiles(record, values),
        "on_industrial": headline.on_industrial(record, values),
        "happenings": happenings[:MOST_HAPPENINGS],
        "more": max(len(happenings) - MOST_HAPPENINGS, 0),
        "extremes": analysis.extremes(record),
        "provenance": {
            name: value for name, value in {**record.run, **record.outcome}.items() if "publishers." not in name
        },
    }


def unbroken(text: str) -> str:
    """Return `text` in which no line ends between a number and its unit."""
    return re.sub(r"(?<=\d) (?=%|(?:[a-zA-Z]{1,3}\b))", "\N{NO-BREAK SPACE}", text)


def _tiles(record: RunRecord, values: Mapping[str, float]) -> list[dict[str, Any]]:
    """Return the figures of a run that are shown large, with what bounds them and what they are made from."""
    found = []
    for key in headline.headline(record, values):
        definition = kpi_set.DEFINITION_OF[key]
        source = source_of(key, record.sources)
        notes = [headline.note(record, key), BESIDE.get(source, "")]
        found.append(
            {
                "name": definition.title,
                "value": definition.text(values[key]),
                "unit": definition.unit,
                "note": "; ".join(text for text in notes if text),
                "source": source,
                "is_missed": headline.is_missed(record, key, values[key]),
            }
        )
    return found


def _groups(columns: Sequence[Mapping[str, float]], sources: Sequence[Mapping[str, str]]) -> list[dict[str, Any]]:
    """Return the figures of merit in groups, with what each is made from; those that nobody knows are left out."""
    shown = kpi_set.shown(columns)
    groups = []
    for group in kpi_set.GROUPS:
        rows = [
            {
                "title": definition.title,
                "symbols": definition.symbols,
                "unit": definition.unit,
                "cells": [
                    {"text": definition.text(column[definition.key]), "source": source_of(definition.key, of)}
                    for column, of in zip(columns, sources, strict=True)
                ],
            }
            for definition in shown
            if definition.group == group
        ]
        if rows:
            groups.append({"name": group, "rows": rows})
    return groups
