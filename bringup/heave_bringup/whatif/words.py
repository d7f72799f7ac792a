"""Answers in words: the table for a terminal, what the record shows, and the values for a machine."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from heave_bags.analyse.kpi_set import DEFINITION_OF

from heave_bringup.whatif.answer import KEYS, Figures
from heave_bringup.whatif.fitness import SAME_PAYOUT, lacks, reported, warnings
from heave_bringup.whatif.identify.prior import AS_THEY_ARE
from heave_bringup.whatif.known import Known, off_sigma
from heave_bringup.whatif.study import Answer

BRIEF = ("unit_efficiency", "unit_sigma_m", "significant_residual_m", "tension_max_n", "winch_speed_max_mps")
"""Figures of the table in a terminal, beside time at limits and the chance of a fade-out."""


@dataclass(frozen=True)
class Result:
    """All that a command has to say.

    Attributes
    ----------
    known : by the record
    recorded : figures of the record itself
    answers : the first asked first
    payout_error : of the same law again, standard deviation and largest [m]
    """

    known: Known
    recorded: Figures
    answers: Sequence[Answer]
    payout_error: tuple[float, float]


def banded(key: str, figures: Figures) -> str:
    """Return the figure of a `key` among `figures` with its band, in the unit of tables."""
    definition, value = DEFINITION_OF[key], figures.values[key]
    if not math.isfinite(value):
        return "-"
    low, high = figures.bands.get(key, (value, value))
    text = definition.text(value)
    return text if low == high else f"{text} ({definition.text(low)} to {definition.text(high)})"


def headings() -> list[str]:
    """Return the headings of the table of answers."""
    titles = [f"{DEFINITION_OF[key].title} [{DEFINITION_OF[key].unit}]" for key in BRIEF]
    return ["law", *titles, "at limits [%]", "fade-out"]


def rows(result: Result) -> list[list[str]]:
    """Return the rows of the table of a `result`: the record itself, then what would have been."""
    limits = _limits(result.recorded) if result.known.past.record.is_own else "-"
    found = [["recorded", *(banded(key, result.recorded) for key in BRIEF), limits, "-"]]
    for answer in result.answers:
        cells = [banded(key, answer.figures) for key in BRIEF]
        found.append([answer.asked.name, *cells, _limits(answer.figures), f"{100.0 * answer.fade_out:.0f} %"])
    return found


def _limits(figures: Figures) -> str:
    return f"{figures.values['time_at_limit_percent']:.1f}"


def check_line(result: Result) -> str:
    """Return the line of the check that comes first in a `result`: the same law again."""
    past, sigma_of_unit = result.known.past, 1e3 * result.known.unexplained.waves
    if not past.record.is_own:
        return (
            "same law again: not asked, the record is of another controller; twin of the unit within "
            f"{sigma_of_unit:.1f} mm of the depth (sigma)"
        )
    sigma, largest = result.payout_error
    verdict = "gives the record again" if largest <= SAME_PAYOUT else "DOES NOT GIVE THE RECORD AGAIN"
    return (
        f"same law again: {verdict}: payout within {1e3 * largest:.2f} mm (sigma {1e3 * sigma:.2f} mm); model of the "
        f"winch alone within {1e3 * past.winch.error:.1f} mm of the encoder, twin of the unit within "
        f"{sigma_of_unit:.1f} mm of the depth (both sigma)"
    )


def report_line(known: Known) -> str:
    """Return what the record shows by what is `known` of it, in one line."""
    return "known from this record: " + "; ".join(
        f"{of} {'yes' if is_reported else 'no'}: {why}" for of, is_reported, why in reported(known)
    )


def identified_rows(known: Known) -> list[list[str]]:
    """Return what was identified, by what is `known`: name, value, standard deviation, and what was assumed."""
    found = []
    for name, value in known.fit.values.items():
        unit, nominal = (AS_THEY_ARE[name], "0") if name in AS_THEY_ARE else ("", "1")
        found.append([name, f"{value:.4g} {unit}".strip(), f"{known.fit.sigma(name):.2g} {unit}".strip(), nominal])
    for name, belief in known.again.beliefs.values.items():
        found.append([f"{name} (adviser)", f"{belief.value:.4g}", f"{belief.sigma:.2g}", "as nominal"])
    if known.fit.source.high_pass.period:
        found.append(["mru.high_pass_period", f"{known.fit.source.high_pass.period:.0f} s", "-", "-"])
    return found


def causes(answers: Sequence[Answer]) -> list[str]:
    """Return a line for each of the `answers` that may give up compensation: how likely, and by what."""
    return [
        f"{one.asked.name}: fades out with a probability of {100.0 * one.fade_out:.0f} %: {one.cause}"
        for one in answers
        if one.fade_out > 0.0
    ]


def to_json(result: Result) -> dict[str, Any]:
    """Return all of a `result` for a machine; bands are of 90 %."""
    known = result.known
    return {
        "same_law_again": {"payout_sigma_m": result.payout_error[0], "payout_largest_m": result.payout_error[1]},
        "reported": {of: {"is_reported": is_reported, "why": why} for of, is_reported, why in reported(known)},
        "identified": {
            name: {"value": value, "sigma": known.fit.sigma(name)} for name, value in known.fit.values.items()
        },
        "beliefs": {name: belief.value for name, belief in known.again.beliefs.values.items()},
        "chi2": known.fit.chi2,
        "uncompensated_sigma_m": off_sigma(known),
        "recorded": {key: result.recorded.values[key] for key in KEYS},
        "warnings": warnings(known, result.answers),
        "answers": [
            {
                "name": one.asked.name,
                "law": one.asked.controller.law,
                **{key: one.figures.values[key] for key in KEYS},
                "bands": {key: list(band) for key, band in one.figures.bands.items()},
                "fade_out_probability": one.fade_out,
                "fade_out_cause": one.cause,
                "record_lacks": lacks(known, one),
            }
            for one in result.answers
        ],
    }
