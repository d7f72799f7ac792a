"""What a step of a procedure left, and the figures of it: each is one entry of one table, beside those of a run.

To add a figure, add an entry to FIGURES. Its key ends in its unit; a ratio has none, and is shown in percent.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from heave_bags.analyse import kpi_set
from heave_bags.analyse.kpis.definition import QUANTITIES, KpiDefinition
from heave_bags.analyse.verdict import Judged
from heave_bags.signals import RunSignals, Signal
from heave_devices.bench.set_signal import WinchTest
from heave_devices.bench.winch import Trace
from heave_node.criteria import Criterion, end_of
from heave_node.numerics.arrays import Array
from heave_node.parameters import ParameterError

GRID = 0.01
"""Step of the time grid on which a winch is compared with its orders [s]."""
LONGEST_LAG = 1.5
"""Largest lag that is looked for [s]."""
SMOOTH = 0.2
"""Time over which a rate is averaged before its largest value counts [s]."""
AT_REST = 0.05
"""A drum slower than this is at rest [m/s], as in the figures of safety."""
REMAINS = 0.5
"""A drum has stopped once it has been at rest for so long [s]."""
STEADY = 1.0
"""An order that stays for so long shows how far the rate overshoots [s]."""


class Following(NamedTuple):
    """How a winch followed its orders: rate(t) = gain ordered(t - lag) + what is left."""

    lag: float = math.nan  # [s]
    gain: float = math.nan  # over the whole window [-]
    least_gain: float = math.nan  # smallest of those of its fifths [-]
    error: float = math.nan  # standard deviation of what is left over that of the rate [-]


@dataclass(frozen=True)
class Nominal:
    """The winch by its data sheet: speed limit [m/s], acceleration limit [m/s^2], lag and delay together [s]."""

    speed: float = math.nan
    acceleration: float = math.nan
    lag: float = math.nan


@dataclass
class Measured:
    """What a step left, and the window of it that is judged."""

    run: RunSignals  # signals that figures of merit are computed from
    start: float  # of the window [s]
    end: float  # of the window [s]
    # ordered payout rate [m/s], positive pays out; an order holds until the next
    ordered_rate: Signal = field(default_factory=Signal)
    event: float = math.nan  # beginning of what was done to the part [s]; NaN: nothing was
    event_end: float = math.nan  # its end [s]; NaN: nothing was done
    # time [s] and code of each; of what a controller holds of a sensor or a winch, its words
    alarms: Sequence[tuple[float, str]] = ()
    # of each sensor, by name: heave [m] of the MRU, depth [m], tension [N], payout [m] and rate [m/s] of the encoder;
    # of a run the payout of its signals is about the programme of depth, that of the encoder is not
    readings: Mapping[str, Signal] = field(default_factory=dict)
    nominal: Nominal = field(default_factory=Nominal)  # the winch as it should be
    notes: list[str] = field(default_factory=list)  # what a reader must know
    lacks: str = ""  # why nothing over the window can be met, in words; "": all of it was recorded

    def reading(self, sensor: str) -> Signal:
        """Return what a `sensor` read within the window; empty where it read nothing."""
        return self.readings.get(sensor, Signal()).window(self.start, self.end)

    @cached_property
    def payout(self) -> Signal:
        """Payout within the window [m]: what the encoder reads, where it is known."""
        return self.reading("encoder") if "encoder" in self.readings else self.run.payout.window(self.start, self.end)

    @cached_property
    def rate(self) -> Signal:
        """Payout rate within the window [m/s]: as it is reported, else the difference of payout."""
        if "encoder_rate" in self.readings:
            return self.reading("encoder_rate")
        if self.run.payout_rate.size:
            return self.run.payout_rate.window(self.start, self.end)
        return rate_of(self.payout) if self.payout.size > 2 else Signal()

    @cached_property
    def grid(self) -> Array:
        """Times at which rate and order are compared [s]; empty where either is not known."""
        rate, ordered = self.rate, self.ordered_rate
        if rate.size < 3 or ordered.size < 3:
            return np.empty(0)
        first, last = max(rate.time[0], ordered.time[0]), min(rate.time[-1], ordered.time[-1])
        return np.arange(first + 0.5 * GRID, last, GRID)  # between samples: an order counts as long before as after

    @cached_property
    def smooth_rate(self) -> Array:
        """The rate at the times of the grid, averaged over SMOOTH [m/s]."""
        width = round(SMOOTH / GRID)
        if self.grid.size <= width:
            return np.empty(0)
        return np.convolve(np.interp(self.grid, self.rate.time, self.rate.value), np.full(width, 1.0 / width), "valid")

    @cached_property
    def following(self) -> Following:
        """How the winch followed its orders, by least squares over the lag.

        The drum's rate is the difference of payout about each sample, where payout is known: the one that is reported
        is often of the time before its sample, and would add to the lag.
        """
        shifts = round(LONGEST_LAG / GRID)
        if self.grid.size < 2 * shifts:
            return Following()
        drum, orders_of = rate_of(self.payout) if self.payout.size > 2 else self.rate, self.ordered_rate
        rate = np.interp(self.grid, drum.time, drum.value)
        ordered = orders_of.value[np.searchsorted(orders_of.time, self.grid, "right") - 1]
        count = rate.size - shifts
        seen, orders = rate[shifts:], [ordered[shifts - k : shifts - k + count] for k in range(shifts + 1)]
        powers = np.array([one @ one for one in orders])
        if powers.min() < count * AT_REST**2:
            return Following()
        explained = np.array([seen @ one for one in orders]) ** 2 / powers
        lag, best = _peak(explained), orders[int(explained.argmax())]
        gain = float(seen @ best / (best @ best))
        whole = float(best @ best) / count
        fifths = [(a, o) for a, o in zip(np.array_split(seen, 5), np.array_split(best, 5), strict=True)]
        gains = [float(a @ o / (o @ o)) for a, o in fifths if o @ o > 0.1 * whole * o.size]
        return Following(GRID * lag, gain, min(gains), float(np.std(seen - gain * best) / np.std(seen)))

    @cached_property
    def _rest(self) -> float:
        """Time from which on the drum is at rest for REMAINS, at the event or after it [s]; NaN where it is not."""
        after = self.rate.window(self.event, self.end) if math.isfinite(self.event) else Signal()
        if not after.size:
            return math.nan
        time = np.array([self.event, *after.time])
        speed = np.abs([np.interp(self.event, self.rate.time, self.rate.value), *after.value])
        places = np.flatnonzero(np.diff([1.0, *(speed >= AT_REST), 1.0]))
        lasted = ((time[first], time[after - 1]) for first, after in zip(places[::2], places[1::2], strict=True))
        return next((float(first) for first, last in lasted if last - first >= REMAINS), math.nan)

    @property
    def was_at_rest(self) -> bool:
        """Whether the drum was not moving when the event came, so that it shows no stop."""
        return self._rest == self.event

    @property
    def stop(self) -> float:
        """Time of the first sample at rest after the event [s]; NaN where there is none, or the drum was at rest."""
        return math.nan if self.was_at_rest else self._rest

    def alarm_time(self, codes: Collection[str] | None = None) -> float:
        """Return the time from the event until the first alarm came [s]; NaN where none did.

        Parameters
        ----------
        codes : of which one counts; None: of any, and what a controller holds of a sensor or a winch
        """
        times = [time for time, code in self.alarms if (codes is None or code in codes) and time >= self.event]
        return min(times) - self.event if times else math.nan

    @cached_property
    def recovery(self) -> float:
        """Time from the end of the event until compensation is active to the end of the window [s]; NaN: it is not."""
        works = self.run.compensating.window(self.event, self.end) if math.isfinite(self.event) else Signal()
        if not works.size or not works.value[-1]:
            return math.nan
        out = works.time[works.value == 0.0]
        return max(float(out[-1]) - self.event_end, 0.0) if out.size else 0.0

    @cached_property
    def depth_gains(self) -> tuple[float, float]:
        """Depth per payout and per heave downwards, by least squares [-]; NaN for what did not move."""
        depth, payout, heave = self.reading("depth"), self.reading("encoder"), self.reading("mru")
        if depth.size < 20:
            return math.nan, math.nan
        columns, places = [np.ones(depth.size)], {}
        for name, signal, least in (("payout", payout, 0.1), ("heave", heave, 0.1)):
            at = signal.at(depth) if signal.size > 2 else np.zeros(depth.size)
            if np.ptp(at) > least:
                places[name] = len(columns)
                columns.append(at)
        found = np.linalg.lstsq(np.column_stack(columns), depth.value, rcond=None)[0]
        per_heave = -float(found[places["heave"]]) if "heave" in places else math.nan
        return float(found[places["payout"]]) if "payout" in places else math.nan, per_heave


def of_winch(trace: Trace, test: WinchTest, nominal: Nominal) -> Measured:
    """Return what figures are computed from, of the `trace` of a `test` of a winch that should be `nominal`."""
    time = trace.rows[:, 0]
    ordered, payout, rate = (Signal(time, trace.rows[:, column]) for column in (1, 2, 3))
    run = RunSignals(payout=payout, payout_rate=rate, speed_limit=nominal.speed)
    if test.load > 0.0:
        run.tension = Signal(time, np.full(time.size, test.load))
    end = float(time[-1]) if math.isfinite(trace.event) else min(test.signal.duration, float(time[-1]))
    lacks = f"unknown, the winch fell silent at {trace.silent:.1f} s" if math.isfinite(trace.silent) else ""
    return Measured(run, 0.0, end, ordered, trace.event, nominal=nominal, lacks=lacks)


def rate_of(payout: Signal) -> Signal:
    """Return the rate [m/s] of a `payout` [m] of more than two samples: its differences about each of them."""
    return Signal(payout.time, np.gradient(payout.value, payout.time))


def _peak(values: Array) -> float:
    """Return the place of the largest of `values`, between them by the parabola through its neighbours."""
    top = int(values.argmax())
    if not 0 < top < values.size - 1:
        return float(top)
    before, at, after = values[top - 1 : top + 2]
    bend = before - 2.0 * at + after
    return top + 0.5 * float(before - after) / float(bend) if bend else float(top)


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
