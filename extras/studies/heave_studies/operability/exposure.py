"""Limit curves of every situation, compensated and locked, against the seas of a place."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import pandas
from heave_node.criteria import Criterion

from heave_studies.operability.limits import limit_curve, situations
from heave_studies.operability.record import HS, SeaRecord, beyond_the_grid, workable, workable_share
from heave_studies.operability.windows import AlphaTable, all_windows, monthly_share, persistence


@dataclass(frozen=True)
class Place:
    """The seas of a place, and what is asked of them."""

    record: SeaRecord  # of the place
    windows: tuple[float, ...]  # lengths of weather windows [h]
    alpha: AlphaTable | None = None  # factors on the limit; None: the forecast is trusted


@dataclass(frozen=True)
class Exposure:
    """A limit curve at a place."""

    share: float  # of the measured seas within the mean limit [-]
    cautious: float  # of those within the lower end of its confidence [-]; NaN where the seeds show none
    outside: float  # share of the seas whose period the study has not run [-]
    # workable share; empty of a scatter diagram, as are the following
    by_month: pandas.Series = field(default_factory=lambda: pandas.Series(dtype=float))
    # waiting times by length of window and month [h]
    windows: pandas.DataFrame = field(default_factory=pandas.DataFrame)
    spells: pandas.DataFrame = field(default_factory=pandas.DataFrame)  # how long workable seas and the others last [h]


@dataclass(frozen=True)
class Situation:
    """What a study found for one heading, depth, ... : limits, and what they mean at a place."""

    name: str  # "" where only the sea was varied
    cases: pandas.DataFrame  # rows of the study's table
    limit: pandas.DataFrame  # by period, with the law of the scenario
    locked_limit: pandas.DataFrame  # by period, with the winch locked
    exposure: Exposure | None  # at the place; None without one
    locked_exposure: Exposure | None  # the same with the winch locked


def study_situations(frame: pandas.DataFrame, criteria: Sequence[Criterion], place: Place | None) -> list[Situation]:
    """Return what a study found.

    Parameters
    ----------
    frame : table of the study
    criteria : that are to hold
    place : whose seas it is held against; None: none
    """
    found = []
    for name, cases in situations(frame):
        limit = limit_curve(cases, criteria)
        locked = limit_curve(cases, criteria, locked=True)
        exposures = [None if place is None else exposure_of(place, curve) for curve in (limit, locked)]
        found.append(Situation(name, cases, limit, locked, *exposures))
    return found


def exposure_of(place: Place, curve: pandas.DataFrame) -> Exposure:
    """Return what a limit curve means at a place.

    Parameters
    ----------
    place : and what is asked of it
    curve : as `limit_curve` gives it
    """
    record = place.record
    cautious = math.nan if curve["lower"].isna().any() else workable_share(record, curve, "lower")
    shares = (workable_share(record, curve), cautious, beyond_the_grid(record, curve))
    if not record.has_order:
        return Exposure(*shares)
    time = pandas.DatetimeIndex(record.states.index)
    flags = workable(record, curve)
    known = np.asarray(record.states[HS].notna())
    of_windows = [(hours, workable(record, curve, alpha=place.alpha, hours=hours)) for hours in place.windows]
    return Exposure(
        *shares,
        by_month=monthly_share(time, flags, known),
        windows=all_windows(time, of_windows, record.step),
        spells=persistence(flags, record.step),
    )


def exposure_json(exposure: Exposure | None) -> dict[str, object] | None:
    """Return an `exposure` as plain data; None where there is none."""
    if exposure is None:
        return None
    return {
        "workable_share": exposure.share,
        "workable_share_lower": exposure.cautious,
        "beyond_the_grid": exposure.outside,
        "by_month": {str(month): float(share) for month, share in exposure.by_month.items()},
        "windows": exposure.windows.to_dict("records"),
        "spells": exposure.spells.to_dict("index"),
    }
