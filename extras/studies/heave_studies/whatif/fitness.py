"""Whether a record can carry an answer, what it shows, and the answers in words."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from heave_bags.analyse.kpi_set import DEFINITION_OF
from heave_bringup.errors import CommandError
from heave_node.sheet import UNKNOWN, Column, Sheet
from winch_controller_node.core.supervision.modes import Mode

from heave_studies.whatif.answer import OFF, Answer, Figures, Known, limit_words, off_sigma, winch_moved
from heave_studies.whatif.identify import BEGINS, DAMPING, INERTIA
from heave_studies.whatif.record import SensorRecord

SHORTEST = 60.0
"""Shortest time that is judged [s]: half a dozen waves."""

LOST = 1.0
"""Longest time without a reading of MRU, depth sensor or encoder that is bridged [s]."""

LARGEST_LEFT = 0.1
"""Motion that the twin does not explain, over that of the unit with the winch locked, above which cable and unit are
something else."""

POOR_CHI2 = 1.5
"""Mean square of what is left of the depth over its noise, above which a report warns."""

WIDE = 0.05
"""Distance from the efficiency to an end of its band above which the record does not suffice [-]."""

FAR = 5.0
"""Standard deviations of what was known before above which an identified value is none of cable, unit or MRU."""

CHECK = "check unit, sign and column of MRU, encoder and depth sensor; length, cable and unit; load cell"
"""What to check where a record does not fit what is assumed."""

SELDOM = 0.05
"""Time at limits that a table shows as none [%]."""

LARGEST_WINCH_ERROR = 0.15
"""Payout that the model of the winch misses, over what the drum moves, above which it is another winch."""


def check_record(record: SensorRecord, start: float, where: str) -> None:
    """Refuse a record that cannot carry an answer.

    Parameters
    ----------
    record : of the sensors
    start : of the window that is judged [s]
    where : the bag, for the message

    Raises CommandError, in one line, for the first reason.
    """
    left = float(record.time[-1]) - max(start, float(record.time[0]) + BEGINS)
    if left < SHORTEST:
        raise CommandError(
            f"{where}: {max(left, 0.0):.0f} s are left after its transient of {start:g} s; {SHORTEST:g} s at least are "
            "needed: record longer, or give another --end"
        )
    read = {"mru": record.mru[:, 0], "depth": record.scalar("depth")[:, 0]}
    read["encoder"] = record.time[[one.winch is not None for one in record.measurements]]
    causes = [(record.operated, "an operator acted, which no other law would have been asked")]
    for sensor, times in read.items():
        edges = np.array([start, *np.sort(times[times > start]), record.time[-1]])
        gaps = np.flatnonzero(np.diff(edges) > LOST)
        causes += [(float(edges[gap]), f"{sensor} was not read until {edges[gap + 1]:.1f} s") for gap in gaps[:1]]
    for time, mode, one in zip(record.time.tolist(), record.modes, record.measurements, strict=True):
        causes += [(time, "a tension was held, as in a landing")] if mode == Mode.CONSTANT_TENSION.value else []
        causes += [(time, "the winch had a fault")] if one.winch and one.winch.fault else []
    time, words = min(causes)
    if math.isfinite(time):
        raise CommandError(f"{where}: from {time:.1f} s on {words}: give --end {time:.0f}")


def check_known(known: Known, where: str) -> None:
    """Refuse an answer where what is `known` contradicts itself; raises CommandError with the reason, `where` in it."""
    slack = np.flatnonzero((known.past.plant.least_tension <= 0.0) & (known.past.record.time >= known.evidence.start))
    if slack.size:
        time = float(known.past.record.time[slack[0]])
        raise CommandError(
            f"{where}: the cable was slack from {time:.1f} s on: what comes before a snap does not tell what comes "
            f"after; give --end {time - 1.0:.0f}"
        )
    off = off_sigma(known)
    if known.left > LARGEST_LEFT * off:
        missed = f"the twin misses the depth by {100.0 * known.left:.1f} cm of {100.0 * off:.1f} cm (sigma)"
        raise CommandError(f"{where}: {missed}: {CHECK}")
    for name, value in known.fit.values.items():
        if (off_prior := known.fit.off_prior(name)) > FAR:
            far = f"{name} is identified as {value:.3g}, {off_prior:.0f} standard deviations from what was known before"
            raise CommandError(f"{where}: {far}: {CHECK}")
    missing, moved = known.past.winch.error, float(np.std(known.past.winch.payout - known.set_point))
    if winch_moved(known) and missing > LARGEST_WINCH_ERROR * moved:
        raise CommandError(
            f"{where}: the winch as identified misses the encoder by {100.0 * missing:.1f} cm of {100.0 * moved:.1f} "
            "cm (sigma): it is another winch; check its time constant, delay and limits"
        )


def reported(known: Known) -> list[tuple[str, bool, str]]:
    """Return what the record shows by what is `known` of it: of what, whether, and why, in words."""
    fit, record, window = known.fit, known.past.record, known.window
    reached, moved = limit_words(record.limits_hit[window]), winch_moved(known)
    plant = f"inertia within {100.0 * fit.sigma(INERTIA):.1f} %, chi2 {fit.chi2:.1f}"
    return [
        ("cable and unit", fit.tells(INERTIA), plant),
        ("damping", fit.tells(DAMPING), f"within {100.0 * fit.sigma(DAMPING):.0f} %"),
        ("winch", moved, "it answered orders" if moved else "it stood still"),
        ("winch limits", bool(reached), f"reached: {reached}" if reached else "they were never reached"),
    ]


def warnings(known: Known, answers: Sequence[Answer]) -> list[str]:
    """Return what a reader of `answers` that stand on what is `known` must be aware of, a line each."""
    lines = []
    if known.fit.chi2 > POOR_CHI2:
        lines.append(
            f"the fit of cable and unit leaves {known.fit.chi2:.1f} times the noise of the depth sensor: the bands "
            "may be too narrow"
        )
    for answer in answers:
        if answer.lost:
            at = answer.figures.lost_at
            shown = f"on the likeliest at {at:.1f} s" if math.isfinite(at) else "not on the likeliest"
            withheld = "; when it does hangs on thresholds, so its figures are withheld" if answer.is_refused else ""
            lines.append(
                f"{answer.asked.law}: gives up compensation on {answer.lost} of {answer.plants} plants that the "
                f"record allows, {shown}: {answer.cause}{withheld}"
            )
        lacking = [] if answer.is_refused else lacks(known, answer)
        if lacking:
            lacked = "; ".join(lacking)
            lines.append(f"{answer.asked.law}: this record does not show all that the answer stands on: {lacked}")
    return lines


def lacks(known: Known, answer: Answer) -> list[str]:
    """Return what the record does not show that an `answer` on what is `known` needs, in words; empty: it suffices."""
    shows = {of: (is_reported, why) for of, is_reported, why in reported(known)}
    efficiency, limit = (answer.figures.values[key] for key in ("unit_efficiency", "time_at_limit_percent"))
    low, high = answer.figures.bands["unit_efficiency"]
    found = []
    if not shows["cable and unit"][0]:
        found.append(f"cable and unit are not known from it ({shows['cable and unit'][1]})")
    if answer.asked.law != OFF and not shows["winch"][0]:
        found.append(f"how the winch answers is assumed ({shows['winch'][1]})")
    if limit >= SELDOM and not shows["winch limits"][0]:
        limits = limit_words(answer.done.limits_hit[known.window])
        found.append(f"it is at the winch's limits ({limits}) for {limit:.1f} % of the time, and they are assumed")
    if max(efficiency - low, high - efficiency) > WIDE:
        found.append(f"its efficiency is anywhere from {100.0 * low:.0f} to {100.0 * high:.0f} %")
    return found


BRIEF = (
    *("unit_efficiency", "unit_sigma_m", "significant_residual_m", "tension_max_n", "winch_speed_max_mps"),
    "time_at_limit_percent",
)
"""Figures of the table in a terminal, beside the chance of a fade-out."""

EXPERIMENTAL = "whatif is experimental: compared with simulated runs alone (docs/guide/howto/what_would_have_been.md)"


class Row(NamedTuple):
    """A row of the table of answers."""

    name: str  # law
    lost: str  # plants on which it gives up compensation, of how many
    figures: Figures  # that are shown


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

    @property
    def rows(self) -> list[Row]:
        """The record itself, then what would have been."""
        lost = ["-" if one.asked.law == OFF else f"{one.lost} of {one.plants}" for one in self.answers]
        found = [Row(one.asked.law, of, one.shown) for one, of in zip(self.answers, lost, strict=True)]
        return [Row("recorded", "-", self.recorded), *found]


def _column(key: str) -> Column:
    """Return the column of the figure of a `key` with its band."""
    definition = DEFINITION_OF[key]

    def banded(row: Row) -> str:
        value = row.figures.values[key]
        if not math.isfinite(value):
            return UNKNOWN
        text, low, high = map(definition.text, (value, *row.figures.bands.get(key, (value, value))))
        return text if low == high else f"{text} ({low} to {high})"

    return Column(f"{definition.title} [{definition.unit}]", banded)


ANSWERS = Sheet(Column("law", "name"), Column("gives up", "lost"), *map(_column, BRIEF))
"""Columns of the answers."""


def lines_before(result: Result) -> list[str]:
    """Return the lines that come before the answers of a `result`: what is known, and what was changed."""
    known = result.known
    shown = "; ".join(f"{of} {'yes' if is_reported else 'no'}: {why}" for of, is_reported, why in reported(known))
    values = {name: f"{value:.3g}" for name, value in known.fit.values.items() if known.fit.tells(name)}
    values |= {name: f"{belief.value:.4g} (adviser)" for name, belief in known.past.record.beliefs.values.items()}
    return [
        f"winch alone within {1e3 * known.past.winch.error:.1f} mm of the encoder, twin of the unit within "
        f"{1e3 * known.unexplained.waves:.1f} mm of the depth (standard deviations)",
        f"known from this record: {shown}",
        f"identified: {', '.join(f'{name} {words}' for name, words in values.items()) or 'nothing'}",
        *([f"each law with {' and '.join(result.settings)}"] if result.settings else []),
    ]


def to_json(result: Result) -> dict[str, Any]:
    """Return all of a `result` for a machine; bands are of 90 %."""
    known = result.known
    return {
        "settings": list(result.settings),
        "reported": {of: is_reported for of, is_reported, _ in reported(known)},
        "identified": {name: [value, known.fit.sigma(name)] for name, value in known.fit.values.items()},
        "chi2": known.fit.chi2,
        "uncompensated_sigma_m": off_sigma(known),
        "recorded": dict(result.recorded.values),
        "warnings": result.warnings,
        "answers": [
            {
                "name": one.asked.law,
                **one.shown.values,
                "bands": {key: list(band) for key, band in one.shown.bands.items()},
                "fade_out_probability": one.lost / one.plants,
                "record_lacks": lacks(known, one),
            }
            for one in result.answers
        ],
    }
