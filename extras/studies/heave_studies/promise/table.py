"""The table of what can differ from the nominal: winch, encoder, cable and unit, MRU, depth sensor, faults, sea.

A row draws one deviation: settings of the simulated ship, of which the controller knows nothing. Seas are those there
are and in which one lifts.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from heave_node.numerics.constants import STANDARD_GRAVITY

from heave_studies.promise.deviation import (
    BELIEF,
    GROUPS,
    TROUBLE,
    Chance,
    Deviation,
    Drawing,
    Fault,
    Nominal,
    Row,
    Settings,
    drawn_fault,
)

STEEPEST, FLATTEST = (8.0, 1.0 / 15.0), (15.0, 1.0 / 25.0)
"""Peak period [s] up to which, and from which on, a sea is at most so steep, 2 pi Hs / (g Tp^2): DNV-RP-C205, 3.5.5."""

HIGHEST, LOWEST = 4.5, 0.3
"""Significant wave heights in which one lifts, and below which nothing moves [m]."""


def highest(period: float) -> float:
    """Return the significant height [m] of the steepest sea of a peak `period` [s]."""
    (short, steep), (long, flat) = STEEPEST, FLATTEST
    share = min(max((period - short) / (long - short), 0.0), 1.0)
    return (steep + share * (flat - steep)) * STANDARD_GRAVITY * period**2 / (2.0 * math.pi)


def sea_of(chance: Chance) -> tuple[float, float]:
    """Return significant height [m] and peak period [s] of a sea that `chance` draws: one in which one lifts."""
    period = chance.between(4.0, 16.0)
    return chance.spread(LOWEST, min(highest(period), HIGHEST)), period


def _values(node: str, values: Callable[[Chance, Nominal], Settings]) -> Drawing:
    """Return how parameters of a `node`, or of a group of one, are drawn by `values`."""
    return lambda chance, nominal: Deviation(
        "", {f"{node}.{name}": value for name, value in values(chance, nominal).items()}
    )


def _other_sea(chance: Chance, _: Nominal) -> Settings:
    height, period = sea_of(chance)
    return {"significant_wave_height": height, "peak_period": period}


def _swell(chance: Chance, nominal: Nominal) -> Settings:
    """Draw a swell beside the wind sea of the scenario."""
    return {
        "spectrum": "ochi_hubble",
        "significant_wave_height": nominal.height,
        "peak_period": nominal.period,
        "swell.significant_wave_height": chance.between(0.5, 2.0),
        "swell.peak_period": chance.between(max(11.0, 1.3 * nominal.period), 19.0),
    }


def _peaked(chance: Chance, nominal: Nominal) -> Settings:
    if nominal.has_swell:
        return _swell(chance, nominal)
    return {"spectrum": "jonswap", "peak_enhancement": chance.between(2.0, 7.0)}


SEA = "wave_vessel"
SEAS = (
    Row("sea", (), _values(SEA, _other_sea), slot="sea", weight=3.0),
    Row("swell beside", (), _values(SEA, _swell), slot="sea"),
    Row("peaked sea", (), _values(SEA, _peaked), slot="sea", weight=0.5),
)
"""Seas other than nominal; none is a reason to blame anything."""

FACTOR, SPEED = "factor", "speed"
"""Actions of an operator: another share of compensation, a speed of lowering [m/s]; NaN would be none, 0 ends it."""
PROGRAMME = f"{BELIEF}.programme"


def _lowering(chance: Chance, _: Nominal) -> Settings:
    return {
        "move_times": [chance.between(90.0, 200.0)],
        "move_payouts": [chance.sign() * chance.between(2.0, 25.0)],
        "move_speeds": [chance.between(0.1, 0.5)],
    }


def _operator_speed(chance: Chance, _: Nominal) -> Deviation:
    start, speed = chance.between(90.0, 220.0), chance.sign() * chance.between(0.05, 0.4)
    return Deviation("", actions=((start, SPEED, speed), (start + chance.between(5.0, 40.0), SPEED, 0.0)))


def _factor_changes(chance: Chance, _: Nominal) -> Deviation:
    first = chance.between(80.0, 160.0)
    then = first + chance.between(20.0, 80.0)
    return Deviation("", actions=((first, FACTOR, chance.between(0.0, 0.9)), (then, FACTOR, 1.0)))


def _stop_and_restart(chance: Chance, _: Nominal) -> Deviation:
    stop = chance.between(90.0, 150.0)
    restart = stop + chance.between(35.0, 80.0)
    mode = chance.one_of(("standby", "stopped"))
    settings = {f"{PROGRAMME}.mode_times": [stop, restart], f"{PROGRAMME}.modes": [mode, "compensating"]}
    return Deviation("", settings, excused=((stop, restart + TROUBLE),))


def _slewing_sea(chance: Chance, nominal: Nominal) -> Settings:
    """Draw a later sea of another period, no steeper than there is."""
    period = nominal.period * chance.beside(0.65, 1.6, 0.15)
    height = min(nominal.height * chance.between(0.6, 1.3), highest(period))
    return _later(height, period, chance)


def _growing_sea(chance: Chance, nominal: Nominal) -> Settings:
    """Draw a sea that grows into that of the scenario, which is up to six times as high."""
    return {
        **_later(nominal.height, nominal.period, chance),
        "significant_wave_height": nominal.height / chance.between(1.5, 6.0),
    }


def _later(height: float, period: float, chance: Chance) -> dict[str, object]:
    values = {
        "significant_wave_height": height,
        "peak_period": period,
        "start": chance.between(40.0, 150.0),
        "duration": chance.between(60.0, 200.0),
    }
    return {f"later_sea.{name}": value for name, value in values.items()}


CHANGING_SEAS = (
    Row("slewing sea", (), _values(SEA, _slewing_sea), slot="sea"),
    Row("growing sea", (), _values(SEA, _growing_sea), slot="sea"),
)

OPERATIONS = (
    Row("lowering", (), _values(PROGRAMME, _lowering)),
    Row("operator's speed", (), _operator_speed),
    Row("factor changes", (), _factor_changes),
    Row("stop and restart", (), _stop_and_restart),
    *CHANGING_SEAS,
)
"""Operations that may be under way besides; none is a reason to blame anything."""


WINCH = "virtual_winch"
CABLE = "cable_sim"
MRU, DEPTH = "wave_vessel.mru", "cable_sim.sensors.depth"
NOISES = {"noise": 0.01, "rate_noise": 0.01, "depth": 0.02}
"""Nominal noise of MRU [m], [m/s] and depth sensor [m] in all scenarios."""


def _limits(name: str, low: float, shares: tuple[float, float]) -> Drawing:
    """Return how a limit of the winch is drawn, and what it is in hauling in."""

    def draw(chance: Chance, nominal: Nominal) -> Settings:
        usual = getattr(nominal, name)
        limit, hauling = chance.between(low * usual, 1.1 * usual), chance.between(*shares)
        settings: dict[str, object] = {f"{name}_limit": limit, f"hauling_{name}_share": hauling}
        if name == "acceleration":
            settings["stop_deceleration"] = min(limit, usual)
        return settings

    return _values(WINCH, draw)


def _drift(*names: str, low: float, high: float) -> Drawing:
    def draw(chance: Chance, _: Nominal) -> Settings:
        when = {"start": chance.between(0.0, 150.0), "duration": chance.between(30.0, 200.0)}
        return {**when, **{name: chance.beside(low, high, 0.1) for name in names}}

    return _values(f"{WINCH}.drift", draw)


def _encoder_scale(chance: Chance, _: Nominal) -> Deviation:
    factor = chance.beside(0.75, 1.3, 0.03)
    return Deviation("", faults=(Fault(GROUPS["encoder"], "scale", 0.0, 0.0, factor),))


def _unit_size(chance: Chance, nominal: Nominal) -> Settings:
    """Return a larger or smaller unit of the same kind: weight and inertia go together."""
    factor = chance.beside(0.7, 1.4, 0.1)
    return {
        "unit.mass": factor * nominal.mass,
        "unit.volume": factor * nominal.volume,
        "unit.added_mass": 3 * [factor * nominal.added_mass],
    }


def _mru_steps(chance: Chance, _: Nominal) -> Settings:
    step = chance.one_of((0.001, 0.005, 0.01, 0.02, 0.05))
    return {"resolution": step, "rate_resolution": step if chance.happens(0.5) else 0.0}


def _fault(chance: Chance, _: Nominal) -> Deviation:
    """Draw a fault in mid-run, as campaign `sensor_faults` does."""
    sensor, kind, magnitude = drawn_fault(chance.random)
    start = chance.between(60.0, 180.0)
    duration = 0.0 if chance.happens(0.5) else chance.between(2.0, 80.0)
    events = [start] if duration == 0.0 else [start, start + duration]
    return Deviation(
        f"{sensor} {kind}",
        faults=(Fault(GROUPS[sensor], kind, start, duration, magnitude),),
        excused=tuple((event, event + TROUBLE) for event in events),
    )


def _row(name: str, part: str | tuple[str, ...], node: str, values: Callable[[Chance, Nominal], Settings]) -> Row:
    """Return the row of a `name` in which parameters of a `node` differ; a finding may blame the `part` for it."""
    return Row(name, (part,) if isinstance(part, str) else part, _values(node, values))


_GEAR = ("encoder", "winch")
_DRUM = ("drum", "encoder", "winch")

DEVIATIONS = (
    Row("speed limits", ("winch",), _limits("speed", 0.4, (0.6, 1.0))),
    Row("acceleration limits", ("winch",), _limits("acceleration", 0.4, (0.5, 1.0))),
    _row("power limit", "winch", WINCH, lambda c, n: {"power_limit": c.between(0.25, 0.9) * n.tension * n.speed}),
    Row("limits that fall", ("winch",), _drift("speed", "acceleration", low=0.4, high=0.9), slot="drift"),
    _row("lag", "winch", WINCH, lambda c, n: {"time_constant": n.lag * c.spread(0.5, 2.5)}),
    _row("delay", "winch", WINCH, lambda c, n: {"command_delay": n.delay + c.between(-0.15, 0.2)}),
    _row("delay jitter", "winch", WINCH, lambda c, _: {"command_jitter": c.spread(1e-3, 0.06)}),
    _row("gain", "winch", WINCH, lambda c, _: {"speed_gain": c.beside(0.75, 1.25, 0.03)}),
    Row("gain that drifts", ("winch",), _drift("gain", low=0.75, high=1.25), slot="drift"),
    _row("dead zone", "winch", WINCH, lambda c, _: {"speed_deadband": c.spread(0.005, 0.06)}),
    _row("creep", "winch", WINCH, lambda c, _: {"creep": c.sign() * c.spread(0.005, 0.05)}),
    _row("play", _GEAR, WINCH, lambda c, _: {"encoder.backlash": c.spread(0.002, 0.03)}),
    _row("encoder resolution", _GEAR, WINCH, lambda c, _: {"encoder.resolution": c.spread(0.002, 0.03)}),
    Row("encoder scale", _GEAR, _encoder_scale),
    _row("drum radius", _DRUM, WINCH, lambda c, _: {"drum_radius_error": c.beside(-0.06, 0.06, 0.01, 0.0)}),
    _row("cable stiffness", "cable", CABLE, lambda c, n: {"cable.axial_stiffness": n.stiffness * c.spread(0.5, 1.8)}),
    _row("cable damping", "cable", CABLE, lambda c, n: {"cable.internal_damping": n.stiffness * c.spread(1e-3, 3e-2)}),
    _row("unit size", "cable", CABLE, _unit_size),
    _row("added mass", "cable", CABLE,
         lambda c, n: {"unit.added_mass": 3 * [n.added_mass * c.beside(0.5, 2.0, 0.15)]}),
    _row("drag", "cable", CABLE, lambda c, n: {"unit.drag_coefficient": 3 * [n.drag * c.spread(0.5, 4.0)]}),
    _row("MRU scale", "mru", MRU, lambda c, _: {"scale_error": c.sign() * c.between(0.03, 0.25)}),
    _row("MRU high-pass", "mru", MRU, lambda c, _: {"high_pass_period": c.between(20.0, 80.0)}),
    _row("MRU noise", "mru", MRU,
         lambda c, _: {name: NOISES[name] * c.between(1.5, 6.0) for name in ("noise", "rate_noise")}),
    replace(_row("MRU noise that is not white", "mru", MRU,
                 lambda c, _: {"wander": c.spread(0.01, 0.06), "wander_time": c.spread(0.3, 6.0)}), slot="wander"),
    replace(_row("MRU wander", "mru", MRU,
                 lambda c, _: {"wander": c.spread(0.05, 0.6), "wander_time": c.spread(30.0, 200.0)}), slot="wander"),
    _row("MRU quantisation", "mru", MRU, _mru_steps),
    _row("MRU time offset", "mru", MRU, lambda c, _: {"stamp_error": c.beside(-0.2, 0.3, 0.02, 0.0)}),
    _row("depth scale", "depth", DEPTH, lambda c, _: {"scale_error": c.beside(-0.1, 0.1, 0.01, 0.0)}),
    _row("depth noise", "depth", DEPTH, lambda c, _: {"noise": NOISES["depth"] * c.between(1.5, 6.0)}),
    _row("depth quantisation", "depth", DEPTH, lambda c, _: {"resolution": c.one_of((0.01, 0.02, 0.05, 0.1))}),
    Row("fault", (), _fault, weight=4.0),
    *SEAS,
)  # fmt: skip
"""All that can differ. What a fault may be blamed on is its sensor."""
