"""The page of a sizing study: one HTML file that opens offline, for a buyer of a winch."""

from __future__ import annotations

import html
import math
from collections.abc import Iterable, Sequence

from heave_bags.report.figure import Figure
from heave_bags.report.parts import notice, table
from heave_bags.report.report import place_figure, render_page
from heave_node.criteria import Criterion
from heave_node.kpi import RATED_SHARE
from heave_node.loads.cycles import DAMAGE_EXPONENT, LEAST_RANGE

from heave_studies.operability.limits import FEWEST_SEEDS
from heave_studies.operability.page import About
from heave_studies.operability.page_parts import (
    cases_table,
    criteria_table,
    number,
    provenance_table,
)
from heave_studies.operability.record import SeaRecord
from heave_studies.sizing.candidates import PARTICULARS
from heave_studies.sizing.figures import limits_figure, sweep_figure
from heave_studies.sizing.study import ENOUGH, OF_THE_WINCH, Duty, Knee, Prices, Sized

FOOTER = f"""SI units. Workable: within the largest sea in which the criteria hold, a mean over the seeds, linear
between the seas that were run. An hour's figures are means over the workable seas of each winch, so that a winch which
works in higher seas is charged with them. Bending cycles: of the piece of rope that is bent most, on one sheave whose
arc of contact is longer than the stroke; count each further sheave. Tension cycles: rainflow count of the top tension
(ASTM E1049-85), ranges of at least {100 * LEAST_RANGE:g} % of its mean. Equivalent tension range: the one that once a
second does the damage of all cycles, by Miner's sum with m = {DAMAGE_EXPONENT:g} (stranded steel wire rope in tension,
DNV-OS-E301 Ch.2 Sec.2). Above half rating: more than {100 * RATED_SHARE:g} % of the winch's speed or power.
For a PDF, print this page."""

ABILITY = (
    "winch",
    "speed [m/s]",
    "acceleration [m/s^2]",
    "power [kW]",
    "delay [s]",
    "workable [%]",
    "mean limit Hs [m]",
)
DUTY = (
    "winch",
    "peak power [kW]",
    "rms power [kW]",
    "energy at the drum [kWh/h]",
    "energy bought [kWh/h]",
    "cost [1/h]",
    "heat [kWh/h]",
    "rope [km/h]",
    "reversals [1/h]",
    "bends [1/h]",
    "above half rating [% of time]",
    "tension cycles [1/h]",
    "equivalent tension range [kN]",
)


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
        f"its sweep gives, all else as the scenario has it.</p>{table(*knee_rows(knees), texts=1)}",
        criteria_table(criteria),
        f"<h2>Winches</h2>{table(ABILITY, ability_rows(found), texts=1)}",
        f'<h2>An hour of compensation</h2><p class="caption">{charged}</p>{table(DUTY, duty_rows(found), texts=1)}',
        "<h2>What each particular is worth</h2>",
        *(place_figure(sweep_figure(found, knee), drawn) for knee in knees),
        "<h2>Limits</h2>",
        *(place_figure(limits_figure(found, particular), drawn) for particular in swept),
        cases_table((one.cases for one in found), criteria, about.table),
        provenance_table(about.facts),
    ]
    return render_page(about.title, "\n".join(body), drawn, footer=FOOTER)


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


def knee_rows(knees: Sequence[Knee]) -> tuple[list[str], list[list[str]]]:
    """Return head and rows of the answer: of each particular in `knees` the scenario's, the knee and what they give."""
    head = ["particular", "knee", "workable, the scenario's [%]", "workable, the best tried [%]"]
    rows = [[knee.particular.heading, knee.text, f"{100 * knee.share:.1f}", f"{100 * knee.best:.1f}"] for knee in knees]
    return head, rows


def ability_rows(found: Sequence[Sized]) -> list[list[str]]:
    """Return a row of ABILITY for each of the winches `found`."""
    return [
        [
            one.winch.title,
            *(particular.text(one.winch.value(particular)) for particular in PARTICULARS),
            _share(one),
            f"{one.limit['limit'].mean():.2f}",
        ]
        for one in found
    ]


def _share(one: Sized) -> str:
    spread = f" ({100 * one.lower:.1f} to {100 * one.upper:.1f})" if one.upper > one.lower else ""
    return f"{100 * one.share:.1f}{spread}"


def duty_rows(found: Sequence[Sized]) -> list[list[str]]:
    """Return a row of DUTY for each of the winches `found`."""
    return [[one.winch.title, *_duty(one.duty)] for one in found]


def _duty(duty: Duty) -> list[str]:
    kilo = (duty.peak, duty.rms, duty.motoring, duty.electric)
    per_hour = (f"{duty.cost:.2f}", number(1e-3 * duty.heat), number(1e-3 * duty.travel))
    counts = (_count(duty.reversals), _count(duty.bending_cycles))
    cycle = (number(duty.loaded), _count(duty.tension_cycles), number(1e-3 * duty.tension_range))
    cells = [*(number(1e-3 * value) for value in kilo), *per_hour, *counts, *cycle]
    return ["-"] * len(cells) if math.isnan(duty.peak) else cells


def _count(value: float) -> str:
    return f"{value:.0f}" if math.isfinite(value) else "-"
