"""Answers in words: the table for a terminal, what the record shows, and the values for a machine."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from heave_bags.analyse.kpi_set import DEFINITION_OF

from heave_studies.whatif.answer import KEYS, Figures
from heave_studies.whatif.fitness import lacks, reported, warnings
from heave_studies.whatif.identify.evidence import AS_THEY_ARE
from heave_studies.whatif.known import OFF, Known, off_sigma
from heave_studies.whatif.study import Answer

BRIEF = ("unit_efficiency", "unit_sigma_m", "significant_residual_m", "tension_max_n", "winch_speed_max_mps")
"""Figures of the table in a terminal, beside time at limits and the chance of a fade-out."""

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
    found = [("recorded", "-", result.recorded)]
    for one in result.answers:
        is_off = one.asked.controller.law == OFF
        found.append((one.asked.name, "-" if is_off else f"{one.lost} of {one.plants}", one.figures))
    return [
        [name, lost, *(banded(key, of) for key in BRIEF), f"{of.values['time_at_limit_percent']:.1f}"]
        for name, lost, of in found
    ]


def lines_before(result: Result) -> list[str]:
    """Return the lines that come before the answers of a `result`: the check, what is known, what was changed."""
    known = result.known
    verdict = "gives the record again" if known.again.is_same else "DOES NOT GIVE THE RECORD AGAIN"
    lines = [
        f"same law again: {verdict}; model of the winch alone within {1e3 * known.past.winch.error:.1f} mm of the "
        f"encoder, twin of the unit within {1e3 * known.unexplained.waves:.1f} mm of the depth (standard deviations)",
        "known from this record: "
        + "; ".join(f"{of} {'yes' if is_reported else 'no'}: {why}" for of, is_reported, why in reported(known)),
        "identified: " + ", ".join(_identified(known)),
    ]
    record = known.past.record
    done = [(tick, one) for tick, of_tick in sorted(record.requests.items()) for one in of_tick]
    if done:
        words = [f"{one.words} at {tick * record.tick_period:.1f} s" for tick, one in done[:MOST_REQUESTS]]
        words += [f"{len(done) - MOST_REQUESTS} more"] if len(done) > MOST_REQUESTS else []
        lines.append(f"requests of the operator, given to each law again: {', '.join(words)}")
    return [*lines, *([f"each law with {' and '.join(result.settings)}"] if result.settings else [])]


def _identified(known: Known) -> list[str]:
    """Return what was identified, with its standard deviation, and by the adviser, in words."""
    found = [
        f"{name} {value:.3g} (sigma {known.fit.sigma(name):.2g}){AS_THEY_ARE.get(name, '')}"
        for name, value in known.fit.values.items()
        if known.fit.tells(name)
    ]
    found += [f"{name} {belief.value:.4g} (adviser)" for name, belief in known.again.beliefs.values.items()]
    period = known.fit.source.high_pass.period
    return [*found, *([f"high-pass of the MRU {period:.0f} s"] if period else [])] or ["nothing"]


def to_json(result: Result) -> dict[str, Any]:
    """Return all of a `result` for a machine; bands are of 90 %."""
    known = result.known
    return {
        "settings": list(result.settings),
        "same_law_again": known.again.is_same,
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
