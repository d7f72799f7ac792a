"""The page of a sizing study: one HTML file that opens offline, for a buyer of a winch."""

from __future__ import annotations

import html
from collections.abc import Iterable, Sequence

from heave_bags.report.figure import Figure
from heave_bags.report.parts import notice, table
from heave_bags.report.report import place_figure, render_page
from heave_node.criteria import Criterion
from heave_node.kpi import RATED_SHARE
from heave_node.loads.cycles import DAMAGE_EXPONENT, LEAST_RANGE
from heave_node.sheet import Sheet

from heave_studies.operability.limits import FEWEST_SEEDS
from heave_studies.operability.page import (
    About,
    cases_table,
    criteria_table,
    provenance_table,
)
from heave_studies.operability.record import SeaRecord
from heave_studies.sizing.figures import limits_figure, sweep_figure
from heave_studies.sizing.sheets import ABILITY, DUTY, KNEES
from heave_studies.sizing.study import ENOUGH, OF_THE_WINCH, Knee, Prices, Sized

FOOTER = f"""SI units. Workable: within the largest sea in which the criteria hold, a mean over the seeds, linear
between the seas that were run. An hour's figures are means over the workable seas of each winch, so that a winch which
works in higher seas is charged with them. Bending cycles: of the piece of rope that is bent most, on one sheave whose
arc of contact is longer than the stroke; count each further sheave. Tension cycles: rainflow count of the top tension
(ASTM E1049-85), ranges of at least {100 * LEAST_RANGE:g} % of its mean. Equivalent tension range: the one that once a
second does the damage of all cycles, by Miner's sum with m = {DAMAGE_EXPONENT:g} (stranded steel wire rope in tension,
DNV-OS-E301 Ch.2 Sec.2). Above half rating: more than {100 * RATED_SHARE:g} % of the winch's speed or power.
For a PDF, print this page."""


def render(
    about: About,
    found: Sequence[Sized],
    knees: Sequence[Knee],
    criteria: Sequence[Criterion],
    seas: SeaRecord,
    prices: Prices,
) -> str:
    """Return the page as HTML.

    Parameters
    ----------
    about : what the page says of the study
    found : its winches, the scenario's own first
    knees : of what was swept
    criteria : that are to hold
    seas : of the place
    prices : of an hour
    """
    drawn: list[Figure] = []
    place = html.escape(seas.name)
    charged = (
        f"Drive efficiency {prices.efficiency:g}, {100 * prices.regeneration:g} % of the regenerated energy used, "
        f"{prices.energy:g} for a kWh."
    )
    swept = [knee.particular for knee in knees]
    body = [
        f"<h1>{html.escape(about.title)}</h1>",
        '<p class="lead">Which winch: what each can work in, and what an hour of it costs</p>',
        *_notices(found),
        f'<h2>Answer</h2><p class="caption">Seas: {place}. The knee gives {100 * ENOUGH:g} % of what the best of '
        f"its sweep gives, all else as the scenario has it.</p>{_table(KNEES, knees)}",
        criteria_table(criteria),
        f"<h2>Winches</h2>{_table(ABILITY, found)}",
        f'<h2>An hour of compensation</h2><p class="caption">{charged}</p>{_table(DUTY, found)}',
        "<h2>What each particular is worth</h2>",
        *(place_figure(sweep_figure(found, knee), drawn) for knee in knees),
        "<h2>Limits</h2>",
        *(place_figure(limits_figure(found, particular), drawn) for particular in swept),
        cases_table((one.cases for one in found), criteria, about.table),
        provenance_table(about.facts),
    ]
    return render_page(about.title, "\n".join(body), drawn, footer=FOOTER)


def _table(sheet: Sheet, rows: Sequence[object]) -> str:
    return table(sheet.headings, sheet.cells(rows), texts=1)


def _notices(found: Sequence[Sized]) -> Iterable[str]:
    if any(one.limit["seeds"].min() < FEWEST_SEEDS for one in found):
        yield notice(
            f"Fewer than {FEWEST_SEEDS} seeds show no confidence: differences of a few percent between winches may be "
            "chance."
        )
    if any(one.limit["is_open"].any() for one in found):
        yield notice(
            "Some winches work in every sea of the study at some period: their limit lies above its largest height."
        )
    if any(one.limit["is_below"].any() for one in found):
        yield notice(
            "Some winches are limited below the smallest height of the study at some period: no sea was run there, and "
            "their limit is estimated, linear from a calm sea on."
        )
    yield notice(
        "The scenario's criteria on the winch's own limits and power are left out: a winch counts by what it does for "
        f"the unit ({', '.join(OF_THE_WINCH)})."
    )
