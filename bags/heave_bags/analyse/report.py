"""The report of one or several runs: one HTML file that opens offline, zooms and prints."""

from __future__ import annotations

import base64
import hashlib
import html
import json
import math
from collections.abc import Mapping, Sequence
from importlib import resources
from pathlib import Path

from heave_bags.analyse import analysis, kpi_set
from heave_bags.analyse.analysis import Extreme
from heave_bags.analyse.report_figures import Figure, comparison_figures, run_figures, without_nan
from heave_bags.analyse.run_record import RunRecord
from heave_bags.errors import BagError

_LEVELS = ("", "warning", "error")
_MOST_ALARMS = 50


def save_report(records: Sequence[RunRecord], output: Path) -> None:
    """Write the report of the runs `records` to `output`. Raises BagError if the file cannot be written."""
    text = render(records)
    try:
        output.parent.mkdir(parents=True, exist_ok=True)
        output.write_text(text, encoding="utf-8")
    except OSError as error:
        raise BagError(f"{output}: the report cannot be written: {error.strerror}") from error


def render(records: Sequence[RunRecord]) -> str:
    """Return the report of `records` as HTML text."""
    title = _title(records)
    body, figures = render_body(records)
    return _page(title, body, figures)


def _title(records: Sequence[RunRecord]) -> str:
    return " and ".join(record.run.get("scenario") or record.name for record in records)


def render_body(records: Sequence[RunRecord]) -> tuple[str, list[Figure]]:
    """Return what a report of `records` says, as HTML, and the figures that its script draws."""
    title = _title(records)
    figures: list[Figure] = []
    body = [_heading(title, records), _kpi_section(records)]
    if len(records) > 1:
        body += ["<h2>Comparison</h2>", *(_plot(figure, figures) for figure in comparison_figures(records))]
    body += [_run_section(record, figures, is_only=len(records) == 1) for record in records]
    return "\n".join(body), figures


def _page(title: str, body: str, figures: Sequence[Figure]) -> str:
    from plotly.offline import get_plotlyjs  # noqa: PLC0415 - slow to import, needed for its script only

    assets = resources.files("heave_bags.analyse") / "report_assets"
    style = (assets / "report.css").read_text(encoding="utf-8")
    script = (assets / "report.js").read_text(encoding="utf-8")
    scripts = [get_plotlyjs(), f"\n{script}"]
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{security_policy(scripts)}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{html.escape(title)} - heave compensation report</title>
<link rel="icon" href="data:,">
<style>
{style}</style>
</head>
<body>
{body}
<footer>SI units; heave positive up, payout positive lowers the unit. Drag to zoom, double-click to see all;
figures over time zoom together. For a PDF, print this page.</footer>
<script>{scripts[0]}</script>
<script type="application/json" id="figures">{_as_script(figures)}</script>
<script>{scripts[1]}</script>
</body>
</html>
"""


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


def _as_script(figures: Sequence[Figure]) -> str:
    """Return the figures as JSON that no text in them can end; what is not a number is null."""
    data = [without_nan(figure.to_mapping()) for figure in figures]
    return json.dumps(data, allow_nan=False).replace("<", "\\u003c")


def _heading(title: str, records: Sequence[RunRecord]) -> str:
    lines = [f"<h1>{html.escape(title)}</h1>", '<p class="lead">Active heave compensation: run report</p>']
    for record in records:
        prefix = f"{record.name}: " if len(records) > 1 else ""
        lines += [f'<div class="notice">{html.escape(prefix + text)}</div>' for text in record.remarks()]
    return "\n".join(lines)


def _kpi_section(records: Sequence[RunRecord]) -> str:
    columns = [record.kpis() for record in records]
    names = "".join(f'<th class="number">{html.escape(record.name)}</th>' for record in records)
    sources = [record.sources for record in records]
    groups = [_kpi_group(group, columns, sources) for group in kpi_set.GROUPS]
    window = "; ".join(f"{record.start:.2f} s to {record.end:.2f} s" for record in records)
    return (
        f'<h2>Figures of merit</h2>\n<p class="caption">Evaluation window: {window}.</p>\n'
        f'<div class="scroll"><table id="kpis"><thead><tr><th>KPI</th>{names}<th>unit</th></tr></thead>\n'
        + "\n".join(groups)
        + "</table></div>"
    )


def _kpi_group(group: str, columns: Sequence[Mapping[str, float]], sources: Sequence[Mapping[str, str]]) -> str:
    """Return the rows of one group of KPIs under its heading, with what each is made from; "" where none is known."""
    rows = []
    for definition in kpi_set.KPI_DEFINITIONS:
        values = [column[definition.key] for column in columns]
        if definition.group == group and any(math.isfinite(value) for value in values):
            made_from = [kpi_set.source_of(definition.key, of_run) for of_run in sources]
            titles = [f' title="{source}"' if source else "" for source in made_from]
            marks = ["" if source in ("", "true") else f" <small>{source}</small>" for source in made_from]
            cells = "".join(
                f'<td class="number"{title}>{definition.text(value)}{mark}</td>'
                for value, title, mark in zip(values, titles, marks, strict=True)
            )
            rows.append(f"<tr><td>{html.escape(definition.title)}</td>{cells}<td>{definition.unit}</td></tr>")
    if not rows:
        return ""
    heading = f'<tr><th class="group" colspan="{len(columns) + 2}">{group}</th></tr>'
    return "\n".join(["<tbody>", heading, *rows, "</tbody>"])


def _run_section(record: RunRecord, figures: list[Figure], *, is_only: bool) -> str:
    plots = "\n".join(_plot(figure, figures) for figure in run_figures(record))
    details = _details(record)
    heading = "Figures" if is_only else f"Run {html.escape(record.name)}"
    return f"<h2>{heading}</h2>\n{plots}\n{details}"


def _plot(figure: Figure, figures: list[Figure]) -> str:
    """Return the place of a figure in the page, and add it to those the script draws."""
    figures.append(figure)
    title, caption = html.escape(figure.title), html.escape(figure.caption)
    return (
        f'<section class="plot"><h3>{title}</h3><p class="caption">{caption}</p>'
        f'<div class="figure" id="figure-{len(figures) - 1}" style="min-height:{figure.height}px"></div></section>'
    )


def _details(record: RunRecord) -> str:
    return (
        "<h3>Extremes, alarms and provenance</h3>"
        f'<div class="tables">{_extremes_table(analysis.extremes(record))}{_alarm_table(record)}</div>'
        f"<details><summary>Where this bag comes from</summary>{_provenance_table(record)}</details>"
    )


def _extremes_table(found: Sequence[Extreme]) -> str:
    rows = "".join(
        f"<tr><td>{html.escape(extreme.name)}</td>"
        f'<td class="number">{extreme.value:.5g}</td><td>{extreme.unit}</td>'
        f'<td class="number">{extreme.time:.2f}</td></tr>'
        for extreme in found
    )
    head = '<tr><th>extreme</th><th class="number">value</th><th>unit</th><th class="number">time [s]</th></tr>'
    return f"<table><thead>{head}</thead><tbody>{rows}</tbody></table>"


def _alarm_table(record: RunRecord) -> str:
    alarms = sorted(record.alarms, key=lambda alarm: alarm.start)
    if not alarms:
        return "<p>No alarms.</p>"
    rows = "".join(
        f'<tr><td class="number">{alarm.start:.2f}</td><td class="number">{alarm.end:.2f}</td>'
        f"<td>{_LEVELS[alarm.level]}</td><td>{html.escape(alarm.name)}</td></tr>"
        for alarm in alarms[:_MOST_ALARMS]
    )
    more = f"<p>and {len(alarms) - _MOST_ALARMS} more</p>" if len(alarms) > _MOST_ALARMS else ""
    head = '<tr><th class="number">from [s]</th><th class="number">to [s]</th><th>level</th><th>alarm</th></tr>'
    return f"<div><table><thead>{head}</thead><tbody>{rows}</tbody></table>{more}</div>"


def _provenance_table(record: RunRecord) -> str:
    rows = "".join(
        f"<tr><td>{html.escape(name)}</td><td><code>{html.escape(value)}</code></td></tr>"
        for name, value in {**record.run, **record.outcome}.items()
        if not name.startswith("publishers.")
    )
    return f"<table><tbody>{rows}</tbody></table>"
