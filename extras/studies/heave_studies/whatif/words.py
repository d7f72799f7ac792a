"""Answers in words: the table for a terminal, what the record shows, and the values for a machine."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from heave_bags.analyse.kpi_set import DEFINITION_OF

from heave_studies.whatif.answer import KEYS, Figures
from heave_studies.whatif.fitness import SAME_PAYOUT, lacks, reported, warnings
from heave_studies.whatif.identify.prior import AS_THEY_ARE
from heave_studies.whatif.known import OFF, Known, off_sigma
from heave_studies.whatif.study import Answer

BRIEF = ("unit_efficiency", "unit_sigma_m", "significant_residual_m", "tension_max_n", "winch_speed_max_mps")
"""Figures of the table in a terminal, beside time at limits and the chance of a fade-out."""


IDENTIFIED = ("identified", "value", "sigma", "assumed", "known by")
"""Headings of the table of what was identified."""

MOST_REQUESTS = 6
"""Requests of an operator that are named."""

EXPERIMENTAL = "whatif is experimental: compared with simulated runs alone (docs/guide/howto/what_would_have_been.md)"


@dataclass(frozen=True)
class Result:
    """All that a command has to say."""

    settings: Sequence[str]  # changes that were asked for, as for `--set`
    notes: Sequence[str]  # on the record as it was read, a line each
    known: Known  # by the record
    recorded: Figures  # figures of the record itself
    answers: Sequence[Answer]  # the first asked first
    payout_error: tuple[float, float]  # of the same law again, standard deviation and largest [m]

    @property
    def warnings(self) -> list[str]:
        """What a reader must be aware of, a line each."""
        return [*self.notes, *warnings(self.known, self.answers)]


def banded(key: str, figures: Figures) -> str:
    """Return the figure of a `key` among `figures` with its band, in the unit of tables."""
    definition, value = DEFINITION_OF[key], figures.values[key]
    if not math.isfinite(value):
        return "-"
    text, low, high = map(definition.text, (value, *figures.bands.get(key, (value, value))))
    return text if low == high else f"{text} ({low} to {high})"


def headings() -> list[str]:
    """Return the headings of the table of answers."""
    titles = [f"{DEFINITION_OF[key].title} [{DEFINITION_OF[key].unit}]" for key in BRIEF]
    return ["law", "gives up", *titles, "at limits [%]"]


def rows(result: Result) -> list[list[str]]:
    """Return the rows of the table of a `result`: the record itself, then what would have been."""
    found = [["recorded", "-", *(banded(key, result.recorded) for key in BRIEF), _limits(result.recorded)]]
    for answer in result.answers:
        cells = [banded(key, answer.figures) for key in BRIEF]
        found.append([answer.asked.name, _gives_up(answer), *cells, _limits(answer.figures)])
    return found


def _gives_up(answer: Answer) -> str:
    """Return on how many plants an `answer` gives up compensation, and when on that of its figures."""
    if answer.asked.controller.law == OFF:
        return "-"
    lost_at = answer.figures.lost_at
    here = f", here at {lost_at:.0f} s" if math.isfinite(lost_at) else ""
    return f"{answer.lost} of {answer.plants}{here}"


def _limits(figures: Figures) -> str:
    return f"{figures.values['time_at_limit_percent']:.1f}"


def check_line(result: Result) -> str:
    """Return the line of the check that comes first in a `result`: the same law again."""
    past, sigma_of_unit = result.known.past, 1e3 * result.known.unexplained.waves
    sigma, largest = result.payout_error
    verdict = "gives the record again" if largest <= SAME_PAYOUT else "DOES NOT GIVE THE RECORD AGAIN"
    return (
        f"same law again: {verdict}: payout within {1e3 * largest:.2f} mm (sigma {1e3 * sigma:.2f} mm); model of the "
        f"winch alone within {1e3 * past.winch.error:.1f} mm of the encoder, twin of the unit within "
        f"{sigma_of_unit:.1f} mm of the depth (standard deviations)"
    )


def lines_before(result: Result) -> list[str]:
    """Return the lines that come before the answers of a `result`: the check, what is known, what was changed."""
    asked = [f"each law with {' and '.join(result.settings)}"] if result.settings else []
    return [check_line(result), report_line(result.known), *_operator_lines(result.known), *asked]


def _operator_lines(known: Known) -> list[str]:
    """Return a line on what the operator of the record requested, as it is `known`; none where that was nothing."""
    record = known.past.record
    done = [(tick, one) for tick, of_tick in sorted(record.requests.items()) for one in of_tick]
    if not done:
        return []
    words = [f"{one.words} at {tick * record.tick_period:.1f} s" for tick, one in done[:MOST_REQUESTS]]
    rest = [f"{len(done) - MOST_REQUESTS} more"] if len(done) > MOST_REQUESTS else []
    return [f"requests of the operator, given to each law again: {', '.join([*words, *rest])}"]


def report_line(known: Known) -> str:
    """Return what the record shows by what is `known` of it, in one line."""
    return "known from this record: " + "; ".join(
        f"{of} {'yes' if is_reported else 'no'}: {why}" for of, is_reported, why in reported(known)
    )


def identified_rows(known: Known) -> list[list[str]]:
    """Return a row for each of IDENTIFIED with what was identified, by what is `known`."""
    found = []
    for name, value in known.fit.values.items():
        unit, nominal = (f" {AS_THEY_ARE[name]}", "0") if name in AS_THEY_ARE else ("", "1")
        by = "this record" if known.fit.is_shown(name) else "--know" if known.fit.tells(name) else "what was assumed"
        found.append([name, *(f"{text}{unit}" for text in _with_sigma(value, known.fit.sigma(name))), nominal, by])
    for name, belief in known.again.beliefs.values.items():
        found.append([name, *_with_sigma(belief.value, belief.sigma), "-", "the adviser"])
    if known.fit.source.high_pass.period:
        found.append(["mru.high_pass_period", f"{known.fit.source.high_pass.period:.0f} s", "-", "-", "this record"])
    return found


def _with_sigma(value: float, sigma: float) -> tuple[str, str]:
    """Return a `value` and its standard deviation, two digits of that and no more of the value."""
    if not sigma > 0.0:
        return f"{value:.4g}", "-"
    decimals = max(1 - math.floor(math.log10(sigma)), 0)
    return f"{value:.{decimals}f}", f"{sigma:.{decimals}f}"


def causes(answers: Sequence[Answer]) -> list[str]:
    """Return a line for each of the `answers` that may give up compensation: on how many plants, and by what."""
    found = []
    for one in answers:
        lost_at = one.figures.lost_at
        if one.lost:
            is_shown = math.isfinite(lost_at)
            shown = f"at {lost_at:.1f} s, and the figures count both before and after" if is_shown else "none"
            found.append(
                f"{one.asked.name}: gives up compensation on {one.lost} of {one.plants} plants "
                f"that the record allows: {one.cause}; in the motion that is shown {shown}"
            )
    return found


def to_json(result: Result) -> dict[str, Any]:
    """Return all of a `result` for a machine; bands are of 90 %."""
    known = result.known
    return {
        "settings": list(result.settings),
        "same_law_again": {"payout_sigma_m": result.payout_error[0], "payout_largest_m": result.payout_error[1]},
        "reported": {of: {"is_reported": is_reported, "why": why} for of, is_reported, why in reported(known)},
        "identified": {
            name: {"value": value, "sigma": known.fit.sigma(name)} for name, value in known.fit.values.items()
        },
        "beliefs": {name: belief.value for name, belief in known.again.beliefs.values.items()},
        "chi2": known.fit.chi2,
        "uncompensated_sigma_m": off_sigma(known),
        "recorded": {key: result.recorded.values[key] for key in KEYS},
        "warnings": result.warnings,
        "answers": [
            {
                "name": one.asked.name,
                "law": one.asked.controller.law,
                **{key: one.figures.values[key] for key in KEYS},
                "bands": {key: list(band) for key, band in one.figures.bands.items()},
                "fade_out_probability": one.fade_out,
                "fade_out_cause": one.cause,
                "fade_out_at_s": one.figures.lost_at,
                "record_lacks": lacks(known, one),
            }
            for one in result.answers
        ],
    }
