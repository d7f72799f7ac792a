"""Whether a record can carry an answer, what it shows, and the answers in words."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from heave_bags.analyse.kpi_set import DEFINITION_OF
from heave_bringup.errors import CommandError
from winch_controller_node.core.supervision.modes import Mode

from heave_studies.whatif.answer import OFF, Answer, Figures, Known, limit_words, off_sigma, winch_moved
from heave_studies.whatif.identify import AS_THEY_ARE, BEGINS, DAMPING, INERTIA
from heave_studies.whatif.record import LOST, Loss, SensorRecord

AFTER_SNAP = 1.0
"""Time before the cable is first slack at which a record is to end [s]."""

SHORTEST = 60.0
"""Shortest time that is judged [s]: half a dozen waves."""

READ_SHARE = 0.5
"""Share of the record in which a sensor must have read."""

LARGEST_LEFT = 0.1
"""Motion that the twin does not explain, over that of the unit with the winch locked, above which cable and unit are
something else."""

POOR_CHI2 = 1.5
"""Mean square of what is left of the depth over its noise, above which a report warns."""

WIDE = 0.05
"""Distance from the efficiency to an end of its band above which the record does not suffice [-]."""

NEEDED = {
    "mru": "the boom tip's motion is not known",
    "depth": "the unit's motion is not known",
    "encoder": "what the drum did is not known",
}
"""Sensors that every answer needs, and why."""

STALE = "stale"
"""Reason of the controller where no reading has come."""

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
            "needed: record longer, or give another --transient or --end"
        )
    spans = {"mru": record.mru[:, 0], "depth": record.scalar("depth")[:, 0]}
    for sensor, times in spans.items():
        seconds = len(np.unique(np.floor(times)))
        if seconds < READ_SHARE * record.duration:
            raise CommandError(f"{where}: {sensor} was read in {seconds} of {record.duration:.0f} s: too little to say")
    silent = sum(one.winch is None or not math.isfinite(one.winch.encoder_payout) for one in record.measurements)
    if silent > (1.0 - READ_SHARE) * record.ticks:
        raise CommandError(
            f"{where}: the encoder was lost in {silent} of {record.ticks} ticks: the payout is not known"
        )
    for loss in sorted(record.losses, key=lambda one: one.start):
        if loss.sensor in NEEDED and _lasted(record, loss, start) > LOST:
            raise CommandError(
                f"{where}: {loss.sensor} was lost from {loss.start:.1f} s to {loss.end:.1f} s ({loss.reason}): "
                f"{NEEDED[loss.sensor]} there; give --end {loss.start:.0f}"
            )
    if math.isfinite(record.operated):
        raise CommandError(
            f"{where}: an operator acted at {record.operated:.1f} s, which no other law would have been asked: give "
            f"--end {record.operated:.0f}"
        )
    held = Mode.CONSTANT_TENSION.value
    if held in record.modes:
        time = float(record.time[record.modes.index(held)])
        raise CommandError(f"{where}: a tension was held from {time:.1f} s on, as in a landing: give --end {time:.0f}")
    faults = [
        float(t) for t, one in zip(record.time, record.measurements, strict=True) if one.winch and one.winch.fault
    ]
    if faults:
        raise CommandError(f"{where}: the winch reported a fault at {faults[0]:.1f} s: give --end {faults[0]:.0f}")


def _lasted(record: SensorRecord, loss: Loss, start: float) -> float:
    """Return how long a `loss` has kept a `record` without readings that count, after its `start` [s]."""
    begun, end = max(loss.start, start), min(loss.end, float(record.time[-1]))
    if loss.reason != STALE or end <= begun:
        return end - begun
    # a controller that was held up gets late what the sensor has read all the same
    times = [time for time in record.times_of(loss.sensor) if begun < time < end]
    return float(np.diff(np.sort([begun, *times, end])).max())


def check_known(known: Known, where: str) -> None:
    """Refuse an answer where what is `known` contradicts itself; raises CommandError with the reason, `where` in it."""
    slack = np.flatnonzero((known.past.plant.least_tension <= 0.0) & (known.past.record.time >= known.evidence.start))
    if slack.size:
        time = float(known.past.record.time[slack[0]])
        raise CommandError(
            f"{where}: the cable was slack from {time:.1f} s on: what comes before a snap does not tell what comes "
            f"after; give --end {time - AFTER_SNAP:.0f}"
        )
    check_fit(known, off_sigma(known), where)
    missed, moved = known.past.winch.error, float(np.std(known.past.winch.payout - known.set_point))
    if winch_moved(known) and missed > LARGEST_WINCH_ERROR * moved:
        raise CommandError(
            f"{where}: the winch as identified misses the encoder by {100.0 * missed:.1f} cm of {100.0 * moved:.1f} cm "
            "(sigma): it is another winch; check its time constant, delay and limits"
        )


def check_fit(known: Known, off: float, where: str) -> None:
    """Refuse cable, unit and MRU that are not as assumed.

    Parameters
    ----------
    known : by a record
    off : standard deviation of the unit with the winch locked [m]
    where : the bag, for the message

    Raises CommandError, in one line, with what to check.
    """
    if known.left > LARGEST_LEFT * off:
        raise CommandError(
            f"{where}: the twin misses the depth by {100.0 * known.left:.1f} cm of {100.0 * off:.1f} cm (sigma): "
            f"{CHECK}"
        )
    for name, value in known.fit.values.items():
        off_prior = known.fit.off_prior(name)
        if off_prior > FAR:
            raise CommandError(
                f"{where}: {name} is identified as {value:.3g}, {off_prior:.0f} standard deviations from what was "
                f"known before: {CHECK}"
            )


def reported(known: Known) -> list[tuple[str, bool, str]]:
    """Return what the record shows by what is `known` of it: of what, whether, and why, in words."""
    fit, record, window = known.fit, known.past.record, known.window
    reached, moved = limit_words(record.limits_hit[window]), winch_moved(known)
    plant = f"inertia within {100.0 * fit.sigma(INERTIA):.1f} %, chi2 {fit.chi2:.1f}"
    winch = "it answered orders" if moved else "it stood still"
    if moved and not known.again.beliefs.values:
        winch += ", as nominal"
    return [
        ("cable and unit", fit.tells(INERTIA), plant),
        ("damping", fit.tells(DAMPING), f"within {100.0 * fit.sigma(DAMPING):.0f} %"),
        ("winch", moved, winch),
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
    if not known.again.is_same:
        lines.append(
            f"the same law parts from the record at {known.again.parted:.1f} s (mode {known.again.mode}, recorded "
            f"{known.again.was or 'unknown'}): a lost message, or another version"
        )
    for answer in answers:
        if answer.lost:
            at = answer.figures.lost_at
            shown = f"on the likeliest at {at:.1f} s" if math.isfinite(at) else "not on the likeliest"
            withheld = "; when it does hangs on thresholds, so its figures are withheld" if answer.is_refused else ""
            lines.append(
                f"{answer.asked.name}: gives up compensation on {answer.lost} of {answer.plants} plants that the "
                f"record allows, {shown}: {answer.cause}{withheld}"
            )
        lacking = [] if answer.is_refused else lacks(known, answer)
        if lacking:
            lacked = "; ".join(lacking)
            lines.append(f"{answer.asked.name}: this record does not show all that the answer stands on: {lacked}")
    return lines


def lacks(known: Known, answer: Answer) -> list[str]:
    """Return what the record does not show that an `answer` on what is `known` needs, in words; empty: it suffices."""
    shows = {of: (is_reported, why) for of, is_reported, why in reported(known)}
    efficiency, limit = (answer.figures.values[key] for key in ("unit_efficiency", "time_at_limit_percent"))
    low, high = answer.figures.bands["unit_efficiency"]
    found = []
    if not shows["cable and unit"][0]:
        found.append(f"cable and unit are not known from it ({shows['cable and unit'][1]})")
    if answer.asked.controller.law != OFF and not shows["winch"][0]:
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
    return ["law", "gives up", *titles]


def rows(result: Result) -> list[list[str]]:
    """Return the rows of the table of a `result`: the record itself, then what would have been."""
    found = [("recorded", "-", result.recorded)]
    for one in result.answers:
        is_off = one.asked.controller.law == OFF
        found.append((one.asked.name, "-" if is_off else f"{one.lost} of {one.plants}", one.shown))
    return [[name, lost, *(banded(key, of) for key in BRIEF)] for name, lost, of in found]


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
    return [*lines, *([f"each law with {' and '.join(result.settings)}"] if result.settings else [])]


def _identified(known: Known) -> list[str]:
    """Return what was identified, with its standard deviation, and by the adviser, in words."""
    found = [
        f"{name} {value:.3g} (sigma {known.fit.sigma(name):.2g}){AS_THEY_ARE.get(name, '')}"
        for name, value in known.fit.values.items()
        if known.fit.tells(name)
    ]
    found += [f"{name} {belief.value:.4g} (adviser)" for name, belief in known.again.beliefs.values.items()]
    period = known.evidence.source.high_pass.period
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
        "recorded": dict(result.recorded.values),
        "warnings": result.warnings,
        "answers": [
            {
                "name": one.asked.name,
                "law": one.asked.controller.law,
                **one.shown.values,
                "bands": {key: list(band) for key, band in one.shown.bands.items()},
                "fade_out_probability": one.fade_out,
                "fade_out_cause": one.cause,
                "fade_out_at_s": one.figures.lost_at,
                "record_lacks": lacks(known, one),
            }
            for one in result.answers
        ],
    }
