"""The seas of a place against a limit curve: which of them are workable."""

from __future__ import annotations

import numpy as np
import pandas
from heave_node.numerics.arrays import Array

from heave_studies.operability.alpha import AlphaTable
from heave_studies.operability.record import HS, TP, SeaRecord
from heave_studies.operability.windows import Flags


def limit_at(curve: pandas.DataFrame, periods: Array, column: str = "limit") -> Array:
    """Return the limit at peak periods, linear between those of the curve and held beyond them.

    Parameters
    ----------
    curve : as `limit_curve` gives it
    periods : any shape [s]
    column : of the curve: limit, lower or upper
    """
    return np.asarray(np.interp(periods, curve["period"], curve[column].fillna(curve["limit"])))


def workable(
    record: SeaRecord, curve: pandas.DataFrame, *, alpha: AlphaTable | None = None, hours: float = 0.0
) -> Flags:
    """Return which seas of a record are within the limit; missing ones are not.

    Parameters
    ----------
    record : of a place
    curve : as `limit_curve` gives it
    alpha : factors on the limit, by the planned duration; None: the forecast is trusted
    hours : planned duration [h]
    """
    states = record.states
    limits = limit_at(curve, states[TP].to_numpy())
    if alpha is not None:
        limits = limits * alpha.factor(hours, limits)
    with np.errstate(invalid="ignore"):
        return np.asarray(states[HS].to_numpy() <= limits)


def workable_share(record: SeaRecord, curve: pandas.DataFrame, column: str = "limit") -> float:
    """Return the share of the measured seas that are within the limit.

    Parameters
    ----------
    record : of a place
    curve : as `limit_curve` gives it
    column : of the curve: limit, lower or upper
    """
    states = record.states.dropna(subset=[HS])
    within = states[HS].to_numpy() <= limit_at(curve, states[TP].to_numpy(), column)
    return float(states["share"].to_numpy() @ within)


def beyond_the_grid(record: SeaRecord, curve: pandas.DataFrame) -> float:
    """Return the share of the measured seas whose period lies outside the curve's, where its end is held.

    Parameters
    ----------
    record : of a place
    curve : as `limit_curve` gives it
    """
    states = record.states.dropna(subset=[HS])
    outside = (states[TP] < curve["period"].min()) | (states[TP] > curve["period"].max())
    return float(states["share"].to_numpy() @ outside.to_numpy())
