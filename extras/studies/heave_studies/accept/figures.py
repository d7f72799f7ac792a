"""Figures of acceptance tests: each is one entry of one table, beside the figures of merit of a run.

To add a figure, add an entry to FIGURES. Its key ends in its unit; a ratio has none, and is shown in percent.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from heave_bags.analyse import kpi_set
from heave_bags.analyse.kpis.definition import QUANTITIES, KpiDefinition
from heave_bags.analyse.verdict import Judged
from heave_bags.signals import Signal
from heave_node.criteria import Criterion, end_of
from heave_node.numerics.arrays import Array
from heave_node.parameters import ParameterError

from heave_studies.accept.measured import GRID, SMOOTH, STEADY, Measured

WINCH, EVENT, SENSORS = "Winch against its orders", "After the event", "Sensors"
RESIDUALS = ("outlet_sigma_m", "unit_sigma_m", "tension_sigma_n", "tension_min_n")
"""The four residuals in use: at the outlet of the winch, at the unit, of the tension, and the smallest tension."""
ACCELERATION_TIME = 0.5
"""Time over which an acceleration is taken [s]."""


def _reached(measured: Measured, seen: Array, limit: float) -> float:
    """Return the largest of what was `seen` over its `limit`, in the weaker of the two directions that were ordered."""
    ordered = measured.ordered_rate.window(measured.start, measured.end).value
    if not seen.size or not ordered.size:
        return math.nan
    ways = [way for way in (1.0, -1.0) if (way * ordered).max() > 0.0]
    return min((float((way * seen).max()) for way in ways), default=math.nan) / limit


def _acceleration_reached(measured: Measured) -> float:
    rate, step = measured.smooth_rate, round(ACCELERATION_TIME / GRID)
    seen = (rate[step:] - rate[:-step]) / ACCELERATION_TIME if rate.size > step else np.empty(0)
    return _reached(measured, seen, measured.nominal.acceleration)


def _steady(measured: Measured) -> Iterator[Array]:
    """Yield the rate over its order while each order that stays is active, from SMOOTH after its start on."""
    ordered = measured.ordered_rate.window(measured.start, measured.end)
    changes = np.flatnonzero(np.diff(ordered.value) != 0.0) + 1
    for first, after in zip([0, *changes], [*changes, ordered.size], strict=True):
        if first < after and ordered.value[first] and ordered.time[after - 1] - ordered.time[first] >= STEADY:
            seen = measured.rate.window(ordered.time[first] + SMOOTH, ordered.time[after - 1]).value
            if seen.size:
                yield seen / ordered.value[first]


def _overshoot(measured: Measured) -> float:
    """Return how far the rate goes beyond an order that stays, over that order."""
    return max((float(one.max()) - 1.0 for one in _steady(measured)), default=math.nan)


def _steady_error(measured: Measured) -> float:
    """Return how far the rate is off an order that stays in the last quarter of its time, a mean, over that order."""
    return max((abs(float(one[-one.size // 4 :].mean()) - 1.0) for one in _steady(measured)), default=math.nan)


def _drift(measured: Measured) -> float:
    payout = measured.payout.value
    return float(np.abs(payout - payout[0]).max()) if payout.size else math.nan


def _distance(measured: Measured) -> float:
    if math.isnan(measured.stop):
        return math.nan
    payout = measured.payout
    return abs(float(np.diff(np.interp([measured.event, measured.stop], payout.time, payout.value))[0]))


def _rate_of(signal: Signal) -> float:
    return (signal.size - 1) / float(np.ptp(signal.time)) if signal.size > 1 else math.nan


def _gap_of(signal: Signal) -> float:
    return float(np.diff(signal.time).max()) if signal.size > 1 else math.nan


def _noise_of(signal: Signal) -> float:
    """Return the standard deviation of white noise on a smooth motion: that of its second differences over sqrt(6)."""
    return float(np.std(np.diff(signal.value, 2)) / math.sqrt(6.0)) if signal.size > 10 else math.nan


def _ratio(key: str, title: str, formula: object, needs: str, group: str = WINCH) -> KpiDefinition:
    return KpiDefinition(key, title, "%", group, formula, 100.0, 1, needs=needs)  # type: ignore[arg-type]


def _time(key: str, title: str, formula: object, needs: str, group: str = WINCH) -> KpiDefinition:
    return KpiDefinition(key, title, "s", group, formula, needs=needs)  # type: ignore[arg-type]


def _of_sensor(name: str, title: str, unit: str) -> tuple[KpiDefinition, ...]:
    """Return the figures of a sensor by its `name` and `title`, whose readings have this SI `unit`."""
    shown, scale = QUANTITIES[unit]
    needs = f"readings of the {title}"
    return (
        KpiDefinition(
            f"{name}_rate_hz", f"{title}, readings", "Hz", SENSORS, lambda m: _rate_of(m.reading(name)), needs=needs
        ),
        _time(f"{name}_gap_max_s", f"{title}, longest gap", lambda m: _gap_of(m.reading(name)), needs, SENSORS),
        KpiDefinition(
            f"{name}_noise_{unit.lower()}",
            f"{title}, noise",
            shown,
            SENSORS,
            lambda m: _noise_of(m.reading(name)),
            scale,
            needs=needs,
        ),
    )


_ORDERS = "orders and payout of the winch"
FIGURES: tuple[KpiDefinition, ...] = (
    _ratio("speed_reached", "speed reached, slower direction, of nominal",
           lambda m: _reached(m, m.smooth_rate, m.nominal.speed), _ORDERS),
    _ratio("acceleration_reached", "acceleration reached, slower direction, of nominal",
           _acceleration_reached, _ORDERS),
    _ratio("following_gain", "speed over ordered speed", lambda m: m.following.gain, _ORDERS),
    _ratio("following_gain_min", "speed over ordered speed, smallest of five parts",
           lambda m: m.following.least_gain, _ORDERS),
    _ratio("following_error", "speed that does not follow, of the speed", lambda m: m.following.error, _ORDERS),
    _time("following_lag_s", "lag behind the orders", lambda m: m.following.lag, _ORDERS),
    _time("lag_excess_s", "lag beyond nominal", lambda m: m.following.lag - m.nominal.lag, _ORDERS),
    _ratio("steady_error", "error of the speed at the end of a step, of the step", _steady_error, _ORDERS),
    _ratio("overshoot", "overshoot of the speed", _overshoot, _ORDERS),
    KpiDefinition("payout_drift_m", "largest movement of the drum", "cm", WINCH, _drift, 100.0, needs="payout"),
    _time("detection_time_s", "from the event until it is detected", lambda m: m.alarm_time(),
          "an event, and a controller that reports it", EVENT),
    _time("stopping_time_s", "from the event to rest", lambda m: m.stop - m.event, "an event, and a stop", EVENT),
    KpiDefinition("stopping_distance_m", "paid out or hauled in from the event to rest", "cm", EVENT, _distance, 100.0,
                  needs="an event, and a stop"),
    _time("recovery_time_s", "from the end of the event until compensation is active for good",
          lambda m: m.recovery, "an event, and compensation after it", EVENT),
    *(one for of in (("mru", "MRU", "m"), ("depth", "depth sensor", "m"), ("load_cell", "load cell", "N"),
                     ("encoder", "encoder", "m")) for one in _of_sensor(*of)),
    _ratio("depth_per_payout", "depth gained per payout", lambda m: m.depth_gains[0],
           "depth, and an encoder that moves", SENSORS),
    _ratio("depth_per_heave", "depth gained per heave downwards", lambda m: m.depth_gains[1],
           "depth, and an MRU that moves", SENSORS),
)  # fmt: skip
"""The table, in the order of the page of figures."""
ALARM_TIME = _time(
    "alarm_time_s", "from the event to its alarm on the panel", lambda _: math.nan, "an alarm of the step", EVENT
)
"""Figure whose value depends on the alarms that the step names."""
STOPS = ("stopping_time_s", "stopping_distance_m")
"""Figures of a drum that moves when the event comes."""
DEFINITIONS: Mapping[str, KpiDefinition] = {one.key: one for one in (*FIGURES, ALARM_TIME)}


def evaluate(measured: Measured, alarms: Sequence[str] = ()) -> dict[str, float]:
    """Return every figure of what a step left, those of a run among them; NaN for what is not known.

    Parameters
    ----------
    measured : of the step
    alarms : codes of which the first counts for ALARM_TIME
    """
    own = {one.key: float(one.formula(measured)) for one in FIGURES}
    own[ALARM_TIME.key] = measured.alarm_time(alarms)
    return {**kpi_set.evaluate(measured.run, measured.start, measured.end), **own}


@dataclass(frozen=True)
class Unjudged(Judged):
    """A criterion that is not met for a reason, `why`, that its value does not show."""

    why: str = ""

    @property
    def got(self) -> str:
        """The reason."""
        return self.why


def judged(criterion: Criterion, values: Mapping[str, float], measured: Measured | None = None) -> Judged:
    """Return a `criterion` with the value that it has among `values`, of what was `measured`."""
    definition = DEFINITIONS.get(criterion.kpi)
    why = measured.lacks if measured is not None else ""
    if measured is not None and criterion.kpi in STOPS and measured.was_at_rest:
        why = why or "unknown, the drum was not moving at the event"
    if why:
        return Unjudged(criterion, math.nan, definition, why)
    return Judged(criterion, values.get(criterion.kpi, math.nan), definition)


def refuse_unknown(criterion: Criterion, where: str) -> None:
    """Raise ParameterError, naming `where` it stands, for a criterion on what is no figure of a step."""
    known = {**kpi_set.DEFINITION_OF, **DEFINITIONS}
    if criterion.kpi in known:
        return
    ratio = criterion.kpi.removesuffix(end_of(criterion.kpi))
    near = difflib.get_close_matches(criterion.kpi, known)
    helps = f"did you mean {' or '.join(near)}?" if near else f"known: {', '.join(known)}"
    if ratio in known:
        helps = f"{ratio} is a ratio or a count, its bound takes no unit but %"
    raise ParameterError(f"{where}: {criterion.kpi} is not a figure; {helps}")


def refuse_plain(criterion: Criterion, given: str, where: str) -> None:
    """Raise ParameterError for a bound above 1 without % on a ratio that is shown in percent: 95 would be 9500 %.

    Parameters
    ----------
    criterion : on a figure that is known
    given : it, as it stands
    where : it stands, for the message
    """
    known = DEFINITIONS.get(criterion.kpi) or kpi_set.DEFINITION_OF[criterion.kpi]
    if known.unit == "%" and known.scale > 1.0 and abs(criterion.bound) > 1.0 and "%" not in given:
        shown = known.bound(criterion.bound)
        raise ParameterError(f"{where}: {criterion.kpi} = {given!r}: is {shown}; write a bound above 1 with its %")
