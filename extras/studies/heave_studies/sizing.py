"""Which winch: the scenario's own and sweeps of one particular at a time about it, and what each can work in."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas
from cable_sim_node.winch.parameters import WinchParameters
from heave_bags.analyse.kpi_set import DEFINITION_OF
from heave_bags.report.figure import LIMIT, OTHER, UNIT, Figure
from heave_node.criteria import Criterion
from heave_node.loads.cycles import DAMAGE_EXPONENT
from heave_node.numerics.arrays import Array
from heave_node.parameters import ParameterError
from heave_node.sheet import Column, Sheet
from scipy.interpolate import RegularGridInterpolator

from heave_studies.operability.limits import HEIGHT, PERIOD, limit_curve
from heave_studies.operability.seas import HS, TP, SeaRecord, workable, workable_share

SPEED, ACCELERATION, POWER, DELAY = "speed", "acceleration", "power", "delay"


@dataclass(frozen=True)
class Particular:
    """A particular of a winch that a buyer pays for."""

    name: str  # of it
    place: str  # of its parameter, for the winch and for the controller's belief of it
    unit: str  # in which people see it
    shares: tuple[float, ...]  # of the scenario's value, tried where none are given
    scale: float = 1.0  # that unit over the SI unit
    costs_when_small: bool = False  # a small value is the dear one, as of a delay

    def text(self, value: float) -> str:
        """Return a `value` as people see it."""
        return "no limit" if math.isinf(value) else f"{self.scale * value:.3g}"

    @property
    def heading(self) -> str:
        """Its name with the unit."""
        return f"{self.name} [{self.unit}]"


PARTICULARS = (
    Particular(SPEED, "system.winch.speed_limit", "m/s", (0.3, 0.5, 0.75)),
    Particular(ACCELERATION, "system.winch.acceleration_limit", "m/s^2", (0.3, 0.5, 0.75)),
    Particular(POWER, "system.winch.power_limit", "kW", (0.1, 0.2, 0.4), scale=1e-3),
    Particular(DELAY, "system.winch.command_delay", "s", (2.0, 4.0), costs_when_small=True),
)
"""Particulars in the order of `Candidate.values`; shares of power refer to static tension times speed limit."""

STOP = "virtual_winch.stop_deceleration"
"""Place of the deceleration of a stop, which cannot be above the acceleration limit."""

PLACES = (*(particular.place for particular in PARTICULARS), STOP)


@dataclass(frozen=True)
class Candidate:
    """A winch that one might buy."""

    speed: float  # its limit [m/s]; infinite: none
    acceleration: float  # its limit [m/s^2]; infinite: none
    power: float  # its limit [W]; infinite: none
    delay: float  # of its commands [s]
    sweep: str = ""  # name of the particular in which it differs from the scenario's own winch; "" is that one

    def value(self, particular: Particular) -> float:
        """Return its value of a `particular`."""
        return float(getattr(self, particular.name))

    @property
    def title(self) -> str:
        """What it is called: by what it differs in."""
        for particular in PARTICULARS:
            if particular.name == self.sweep:
                return f"{particular.name} {particular.text(self.value(particular))} {particular.unit}".strip()
        return "the scenario's"


def own_winch(winch: WinchParameters) -> Candidate:
    """Return the winch of a scenario as a candidate; raises ParameterError for a drive that has no such limits."""
    if winch.drive != "speed_servo":
        raise ParameterError(
            f"virtual_winch.drive = {winch.drive}: its limits follow from its physics; a study of sizes needs "
            "--set virtual_winch.drive=speed_servo"
        )
    return Candidate(winch.speed_limit, winch.acceleration_limit, winch.power_limit or math.inf, winch.command_delay)


def candidates(own: Candidate, static_tension: float, given: Mapping[str, Sequence[float] | None]) -> list[Candidate]:
    """Return the winches to be tried: the scenario's own first, then the sweeps.

    Parameters
    ----------
    own : winch of the scenario
    static_tension : at the top [N]; with the speed limit it gives the powers that are tried
    given : values by name of the particular, SI units; None takes shares of the scenario's, an empty list none

    Raises ParameterError for a value that is not above 0.
    """
    found = [own]
    for particular in PARTICULARS:
        values = given.get(particular.name)
        if values is None:
            whole = static_tension * own.speed if particular.name == POWER else own.value(particular)
            values = [share * whole for share in particular.shares if whole > 0.0]
        least = 0.0 if particular.name == DELAY else math.ulp(0.0)
        for value in values:
            if not least <= value < math.inf:
                raise ParameterError(
                    f"ask: {particular.name} = {value:g}: must be a number above 0 [{particular.unit}]"
                )
        others = sorted(set(values) - {own.value(particular)})
        found += [replace(own, **{particular.name: value}, sweep=particular.name) for value in others]
    return found


def as_link(winches: Sequence[Candidate], stop_deceleration: float) -> dict[str, tuple[object, ...]]:
    """Return candidates as parameters that move together.

    Parameters
    ----------
    winches : the candidates
    stop_deceleration : of the scenario's winch [m/s^2]; a weaker one stops with all it has
    """
    rows = [
        (
            winch.speed,
            winch.acceleration,
            0.0 if math.isinf(winch.power) else winch.power,
            winch.delay,
            min(stop_deceleration, winch.acceleration),
        )
        for winch in winches
    ]
    return {place: tuple(column) for place, column in zip(PLACES, zip(*rows, strict=True), strict=True)}


def of_frame(frame: pandas.DataFrame) -> list[tuple[Candidate, pandas.DataFrame]]:
    """Return the candidates in the table of a study (`frame`), the scenario's own first, each with its cases.

    Raises ParameterError where the table is of another study.
    """
    missing = [place for place in PLACES if place not in frame.columns]
    if missing:
        raise ParameterError(f"its cases do not vary {missing[0]}: it is no table of a sizing study")
    own: Candidate | None = None
    found = []
    for values, cases in frame.groupby(list(PLACES[:-1]), sort=False):
        speed, acceleration, power, delay = map(float, values)
        winch = Candidate(speed, acceleration, power or math.inf, delay)
        own = own or winch
        differing = [one.name for one in PARTICULARS if winch.value(one) != own.value(one)]
        found.append((replace(winch, sweep=differing[0] if differing else ""), cases))
    return found


OF_THE_WINCH = (
    "time_at_speed_limit_percent",
    "time_at_acceleration_limit_percent",
    "time_at_limit_percent",
    "power_peak_w",
)
"""Criteria that judge a winch by how much of it is used: left out here, where what it does for the unit counts."""

ENOUGH = 0.95
"""The knee is where a particular gives so much of what the best of its sweep gives."""

EVEN_STEPS = 25
"""Wave heights at which the seas of a study are counted where no place is given."""


OF_AN_HOUR: Mapping[str, Callable[[Array, Array], float]] = {
    "power_peak_w": lambda _, values: float(values.max()),
    "power_rms_w": lambda weights, values: math.sqrt(weights @ values**2),
    "energy_wh_per_h": np.dot,
    "energy_regenerated_wh_per_h": np.dot,
    "rope_travel_m_per_h": np.dot,
    "reversals_per_h": np.dot,
    "bending_cycles_per_h": np.dot,
    "time_above_half_rating_percent": np.dot,
    "tension_cycles_per_h": np.dot,
    "tension_range_equivalent_n": lambda weights, values: (
        float(weights @ values**DAMAGE_EXPONENT) ** (1.0 / DAMAGE_EXPONENT)
    ),
}
"""What an hour of compensation asks of a winch: figures of merit, and what they come to over seas with weights; the
range of the tension is that which once a second does the damage of all cycles in the seas' mix.
"""


@dataclass(frozen=True)
class Sized:
    """What a study found of one winch."""

    winch: Candidate  # the candidate
    limit: pandas.DataFrame  # by period, as `limit_curve` gives it
    share: float  # of the place's seas that are workable [-]
    lower: float  # lower end of its confidence [-]
    upper: float  # upper end of its confidence [-]
    duty: Mapping[str, float]  # of an hour, by figure of merit


@dataclass(frozen=True)
class Knee:
    """Where more of a particular gains little."""

    particular: Particular  # of the winch
    # that gives ENOUGH of the best, linear between the values tried, SI; NaN where only winches without a limit do
    value: float
    share: float  # workable share at the scenario's own value [-]
    best: float  # workable share at the best value [-]
    is_open: bool  # the least (of a delay the largest) value tried gives enough already: the knee lies beyond it

    @property
    def text(self) -> str:
        """The value as people see it."""
        if math.isnan(self.value):
            return "above all tried"
        beyond = "at least" if self.particular.costs_when_small else "at most"
        return f"{beyond} {self.particular.text(self.value)}" if self.is_open else self.particular.text(self.value)


def even_seas(frame: pandas.DataFrame) -> SeaRecord:
    """Return the seas of a study, every height up to its largest and every period equally often: no place is known.

    Parameters
    ----------
    frame : table of the study
    """
    top = float(frame[HEIGHT].max())
    heights = (np.arange(EVEN_STEPS) + 0.5) * top / EVEN_STEPS
    grid = pandas.MultiIndex.from_product([sorted(frame[PERIOD].unique()), heights], names=[TP, HS])
    states = grid.to_frame(index=False).assign(share=1.0 / len(grid))
    return SeaRecord(f"all seas up to Hs {top:g} m, each as often", states, math.nan)


def size_winches(frame: pandas.DataFrame, criteria: Sequence[Criterion], seas: SeaRecord) -> list[Sized]:
    """Return what each winch of a study can work in, and what an hour asks of it, the scenario's own first.

    Parameters
    ----------
    frame : table of the study
    criteria : that are to hold
    seas : of the place

    Raises ParameterError for the table of another study.
    """
    found = []
    for winch, cases in of_frame(frame):
        limit = limit_curve(cases, criteria)
        share, lower, upper = (workable_share(seas, limit, column) for column in ("limit", "lower", "upper"))
        found.append(Sized(winch, limit, share, lower, upper, duty_of(cases, limit, seas)))
    return found


def duty_of(cases: pandas.DataFrame, limit: pandas.DataFrame, seas: SeaRecord) -> dict[str, float]:
    """Return what an hour of compensation asks of a winch, by figure of merit; NaN where it can work nowhere.

    Figures are linear between the seas that were run, 0 in a calm sea, and held beyond the grid.

    Parameters
    ----------
    cases : of this winch
    limit : by period; an hour counts in which the sea is within it
    seas : of the place
    """
    states = seas.states[workable(seas, limit)]
    weights = states["share"].to_numpy()
    if not weights.size:
        return dict.fromkeys(OF_AN_HOUR, math.nan)
    weights = weights / weights.sum()
    return {kpi: float(of(weights, _at(cases, kpi, states))) for kpi, of in OF_AN_HOUR.items()}


def _at(cases: pandas.DataFrame, kpi: str, states: pandas.DataFrame) -> Array:
    """Return a figure of merit at seas, its mean over the seeds."""
    grid = cases.pivot_table(index=PERIOD, columns=HEIGHT, values=kpi, aggfunc="mean", dropna=False)
    grid = grid.bfill(axis=1).ffill(axis=1)  # of a case that could not be run: as in the sea beside it
    grid.insert(0, 0.0, 0.0)
    periods, heights = grid.index.to_numpy(dtype=float), grid.columns.to_numpy(dtype=float)
    points = np.column_stack(
        [
            np.clip(states[TP].to_numpy(), periods[0], periods[-1]),
            np.clip(states[HS].to_numpy(), 0.0, heights[-1]),
        ]
    )
    return np.asarray(RegularGridInterpolator((periods, heights), grid.to_numpy(dtype=float))(points))


def knees(found: Sequence[Sized]) -> list[Knee]:
    """Return the knee of each particular that was swept.

    Parameters
    ----------
    found : winches of a study, the scenario's own first
    """
    own = found[0]
    sweeps = [(one, sweep_of(found, one)) for one in PARTICULARS]
    return [_knee(particular, own, sweep) for particular, sweep in sweeps if len(sweep) > 1]


def sweep_of(found: Sequence[Sized], particular: Particular) -> list[Sized]:
    """Return the winches that differ from the scenario's in a `particular`, and that one, by rising value.

    Parameters
    ----------
    found : winches of a study, the scenario's own first
    particular : that was swept
    """
    part = [one for number, one in enumerate(found) if not number or one.winch.sweep == particular.name]
    return sorted(part, key=lambda one: one.winch.value(particular))


def _knee(particular: Particular, own: Sized, sweep: Sequence[Sized]) -> Knee:
    """Go from the cheap end of a sweep to where it gives enough."""
    ordered = list(reversed(sweep)) if particular.costs_when_small else list(sweep)
    values = [one.winch.value(particular) for one in ordered]
    shares = np.maximum.accumulate([one.share for one in ordered])  # a dearer winch is not worse but by chance
    wanted = ENOUGH * float(shares[-1])
    first = int(np.argmax(shares >= wanted))
    if first == 0:
        return Knee(particular, values[0], own.share, float(shares[-1]), is_open=True)
    if math.isinf(values[first]):
        return Knee(particular, math.nan, own.share, float(shares[-1]), is_open=False)
    way = (wanted - shares[first - 1]) / (shares[first] - shares[first - 1])
    value = values[first - 1] + float(way) * (values[first] - values[first - 1])
    return Knee(particular, value, own.share, float(shares[-1]), is_open=False)


KNEES = Sheet(
    Column("particular", "particular.heading"),
    Column("knee", "text"),
    Column("workable, the scenario's [%]", "share", form=".1f", scale=100.0),
    Column("workable, the best tried [%]", "best", form=".1f", scale=100.0),
)
"""The answer: of each particular the knee, and what the scenario's value and the best one give."""


def _share(one: Sized) -> str:
    spread = f" ({100 * one.lower:.1f} to {100 * one.upper:.1f})" if one.upper > one.lower else ""
    return f"{100 * one.share:.1f}{spread}"


TITLE = Column("winch", "winch.title", "winch")
_KEYS = ("speed_mps", "acceleration_mps2", "power_limit_w", "delay_s")

ABILITY = Sheet(
    TITLE,
    *(Column(one.heading, f"winch.{one.name}", key, one.text) for one, key in zip(PARTICULARS, _KEYS, strict=True)),
    Column("workable [%]", _share),
    Column("", "share", "workable_share"),
    Column("", "lower", "workable_share_lower"),
    Column("", "upper", "workable_share_upper"),
    Column("mean limit Hs [m]", lambda one: float(one.limit["limit"].mean()), "limit_mean_m", ".2f"),
)
"""What each winch can work in."""


def _duty_column(kpi: str) -> Column:
    of = DEFINITION_OF[kpi]
    return Column(f"{of.title} [{of.unit}]".replace(" []", ""), lambda one: one.duty[kpi], kpi, of.text)


DUTY = Sheet(TITLE, *map(_duty_column, OF_AN_HOUR))
"""What an hour of compensation asks of each winch."""

BUYERS = Sheet(ABILITY, *DUTY[1:])
"""The buyer's table, for machines."""


def sweep_figure(found: Sequence[Sized], knee: Knee) -> Figure:
    """Return what a particular is worth: workable seas over its values, with the knee.

    Parameters
    ----------
    found : winches of a study, the scenario's own first
    knee : of the particular
    """
    particular = knee.particular
    sweep = [one for one in sweep_of(found, particular) if math.isfinite(one.winch.value(particular))]
    values = [particular.scale * one.winch.value(particular) for one in sweep]
    shares = [100.0 * one.share for one in sweep]
    spread = {
        "type": "data",
        "symmetric": False,
        "array": [100.0 * (one.upper - one.share) for one in sweep],
        "arrayminus": [100.0 * (one.share - one.lower) for one in sweep],
        "color": UNIT,
    }
    traces = [_line("workable seas", values, shares, UNIT, error_y=spread)]
    if math.isfinite(knee.value) and not knee.is_open:
        traces.append(_upright("knee", particular.scale * knee.value, LIMIT, "dash"))
    own = found[0].winch.value(particular)
    if math.isfinite(own):
        traces.append(_upright("the scenario's", particular.scale * own, OTHER, "dot"))
    return Figure(
        f"What {particular.name} is worth",
        _caption(found, particular),
        traces,
        {
            "xaxis": {"title": {"text": particular.heading}, "rangemode": "tozero"},
            "yaxis": {"title": {"text": "workable [%]"}, "range": [0, 105]},
            "hovermode": "closest",
        },
        is_over_time=False,
        height=340,
    )


def _caption(found: Sequence[Sized], particular: Particular) -> str:
    words = "Everything else as the scenario has it."
    unlimited = [one for one in sweep_of(found, particular) if math.isinf(one.winch.value(particular))]
    return words + "".join(f" Without a limit {100.0 * one.share:.1f} % are workable." for one in unlimited)


def _line(name: str, x: Sequence[float], y: Sequence[float], colour: str, **more: Any) -> dict[str, Any]:
    line = {"color": colour, "width": 2.5}
    return {"name": name, "x": list(x), "y": list(y), "mode": "lines+markers", "line": line, **more}


def _upright(name: str, x: float, colour: str, dash: str) -> dict[str, Any]:
    line = {"color": colour, "width": 1.5, "dash": dash}
    hover = f"{name}: {x:.3g}<extra></extra>"
    return {"name": name, "x": [x, x], "y": [0, 105], "mode": "lines", "line": line, "hovertemplate": hover}
