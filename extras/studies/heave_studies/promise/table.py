"""The table of what can differ from the nominal: winch, encoder, cable and unit, MRU, depth sensor, faults, sea.

A row draws one deviation. Its settings are of the simulated ship; what an informed controller would get of them, if
it has a parameter for that, stands beside them. Seas are those there are and in which one lifts.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

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


def _other_sea(chance: Chance, _: Nominal) -> Deviation:
    height, period = sea_of(chance)
    values = {"significant_wave_height": height, "peak_period": period}
    return Deviation(
        "",
        {f"wave_vessel.{name}": value for name, value in values.items()},
        {f"{BELIEF}.sea.{name}": value for name, value in values.items()},
    )


def _swell(chance: Chance, nominal: Nominal) -> Deviation:
    """Draw a swell beside the wind sea of the scenario."""
    values = {
        "spectrum": "ochi_hubble",
        "significant_wave_height": nominal.height,
        "peak_period": nominal.period,
        "swell.significant_wave_height": chance.between(0.5, 2.0),
        "swell.peak_period": chance.between(max(11.0, 1.3 * nominal.period), 19.0),
    }
    told = {f"{BELIEF}.sea.{name}": value for name, value in values.items()}
    return Deviation(
        "",
        {f"wave_vessel.{name}": value for name, value in values.items()},
        {**told, f"{BELIEF}.sea.filter_states": 10},
    )


def _peaked(chance: Chance, nominal: Nominal) -> Deviation:
    if nominal.has_swell:
        return _swell(chance, nominal)
    values = {"spectrum": "jonswap", "peak_enhancement": chance.between(2.0, 7.0)}
    return Deviation(
        "",
        {f"wave_vessel.{name}": value for name, value in values.items()},
        {f"{BELIEF}.sea.{name}": value for name, value in values.items()},
    )


SEAS = (
    Row("sea", (), _other_sea, slot="sea", weight=3.0),
    Row("swell beside", (), _swell, slot="sea"),
    Row("peaked sea", (), _peaked, slot="sea", weight=0.5),
)
"""Seas other than nominal; none is a reason to blame anything."""

FACTOR, SPEED = "factor", "speed"
"""Actions of an operator: another share of compensation, a speed of lowering [m/s]; NaN would be none, 0 ends it."""


def _lowering(chance: Chance, _: Nominal) -> Deviation:
    programme = f"{BELIEF}.programme"
    settings = {
        f"{programme}.move_times": [chance.between(90.0, 200.0)],
        f"{programme}.move_payouts": [chance.sign() * chance.between(2.0, 25.0)],
        f"{programme}.move_speeds": [chance.between(0.1, 0.5)],
    }
    return Deviation("", settings, {})


def _operator_speed(chance: Chance, _: Nominal) -> Deviation:
    start, speed = chance.between(90.0, 220.0), chance.sign() * chance.between(0.05, 0.4)
    return Deviation("", {}, {}, actions=((start, SPEED, speed), (start + chance.between(5.0, 40.0), SPEED, 0.0)))


def _factor_changes(chance: Chance, _: Nominal) -> Deviation:
    first = chance.between(80.0, 160.0)
    then = first + chance.between(20.0, 80.0)
    return Deviation("", {}, {}, actions=((first, FACTOR, chance.between(0.0, 0.9)), (then, FACTOR, 1.0)))


def _stop_and_restart(chance: Chance, _: Nominal) -> Deviation:
    stop = chance.between(90.0, 150.0)
    restart = stop + chance.between(35.0, 80.0)
    mode = chance.one_of(("standby", "stopped"))
    settings = {f"{BELIEF}.programme.mode_times": [stop, restart], f"{BELIEF}.programme.modes": [mode, "compensating"]}
    return Deviation("", settings, {}, excused=((stop, restart + TROUBLE),))


def _slewing_sea(chance: Chance, nominal: Nominal) -> Deviation:
    """Draw a later sea of another period, no steeper than there is."""
    period = nominal.period * chance.beside(0.65, 1.6, 0.15)
    height = min(nominal.height * chance.between(0.6, 1.3), highest(period))
    return Deviation("", _later(height, period, chance), {})


def _growing_sea(chance: Chance, nominal: Nominal) -> Deviation:
    """Draw a sea that grows into that of the scenario, which is up to six times as high."""
    settings = {
        **_later(nominal.height, nominal.period, chance),
        "wave_vessel.significant_wave_height": nominal.height / chance.between(1.5, 6.0),
    }
    return Deviation("", settings, {})


def _later(height: float, period: float, chance: Chance) -> dict[str, object]:
    values = {
        "significant_wave_height": height,
        "peak_period": period,
        "start": chance.between(40.0, 150.0),
        "duration": chance.between(60.0, 200.0),
    }
    return {f"wave_vessel.later_sea.{name}": value for name, value in values.items()}


CHANGING_SEAS = (
    Row("slewing sea", (), _slewing_sea, slot="sea"),
    Row("growing sea", (), _growing_sea, slot="sea"),
)

OPERATIONS = (
    Row("lowering", (), _lowering),
    Row("operator's speed", (), _operator_speed),
    Row("factor changes", (), _factor_changes),
    Row("stop and restart", (), _stop_and_restart),
    *CHANGING_SEAS,
)
"""Operations that may be under way besides; none is a reason to blame anything."""


WINCH = "virtual_winch"
MRU, DEPTH = "wave_vessel.mru", "cable_sim.sensors.depth"
NOISES = {"noise": 0.01, "rate_noise": 0.01, "depth": 0.02}
"""Nominal noise of MRU [m], [m/s] and depth sensor [m] in all scenarios."""


def of_winch(told: str, value: Callable[[Chance, Nominal], Mapping[str, float]]) -> Drawing:
    """Return how settings of the winch are drawn by `value`; an informed controller has the first as `told`."""

    def draw(chance: Chance, nominal: Nominal) -> Deviation:
        drawn = value(chance, nominal)
        known = {f"{BELIEF}.winch.{told}": next(iter(drawn.values()))} if told else None
        return Deviation("", {f"{WINCH}.{name}": number for name, number in drawn.items()}, known)

    return draw


def with_nothing_to_tell(values: Callable[[Chance], Settings]) -> Drawing:
    """Return how settings are drawn, by `values`, that an informed controller need not know."""
    return lambda chance, _: Deviation("", values(chance), {})


def that_cannot_be_told(values: Callable[[Chance], Settings]) -> Drawing:
    """Return how settings are drawn, by `values`, for which the controller has no parameter."""
    return lambda chance, _: Deviation("", values(chance))


def _limits(name: str, low: float, shares: tuple[float, float]) -> Drawing:
    """Return how a limit of the winch is drawn, and what it is in hauling in."""

    def draw(chance: Chance, nominal: Nominal) -> Deviation:
        usual = getattr(nominal, name)
        limit, hauling = chance.between(low * usual, 1.1 * usual), chance.between(*shares)
        settings = {f"{WINCH}.{name}_limit": limit, f"{WINCH}.hauling_{name}_share": hauling}
        if name == "acceleration":
            settings[f"{WINCH}.stop_deceleration"] = min(limit, usual)
        return Deviation("", settings, {f"{BELIEF}.winch.{name}_limit": limit * hauling})

    return draw


def _drift(*names: str, low: float, high: float) -> Drawing:
    def draw(chance: Chance, _: Nominal) -> Deviation:
        when = {"start": chance.between(0.0, 150.0), "duration": chance.between(30.0, 200.0)}
        reached = {name: chance.beside(low, high, 0.1) for name in names}
        return Deviation("", {f"{WINCH}.drift.{name}": value for name, value in {**when, **reached}.items()})

    return draw


def _power(chance: Chance, nominal: Nominal) -> Deviation:
    power = chance.between(0.25, 0.9) * nominal.tension * nominal.speed
    return Deviation("", {f"{WINCH}.power_limit": power}, {f"{BELIEF}.winch.power_limit": power})


def _encoder_scale(chance: Chance, _: Nominal) -> Deviation:
    factor = chance.beside(0.75, 1.3, 0.03)
    return Deviation("", faults=(Fault(GROUPS["encoder"], "scale", 0.0, 0.0, factor),))


def _shared(values: Callable[[Chance, Nominal], Settings]) -> Drawing:
    """Return how settings of the plant are drawn that the controller knows by the same names."""

    def draw(chance: Chance, nominal: Nominal) -> Deviation:
        drawn = values(chance, nominal)
        settings = {f"cable_sim.{name}": value for name, value in drawn.items()}
        return Deviation("", settings, {f"{BELIEF}.{name}": value for name, value in drawn.items()})

    return draw


def _unit_size(chance: Chance, nominal: Nominal) -> Settings:
    """Return a larger or smaller unit of the same kind: weight and inertia go together."""
    factor = chance.beside(0.7, 1.4, 0.1)
    return {
        "unit.mass": factor * nominal.mass,
        "unit.volume": factor * nominal.volume,
        "unit.added_mass": 3 * [factor * nominal.added_mass],
    }


def _mru_scale(chance: Chance, _: Nominal) -> Deviation:
    error = chance.sign() * chance.between(0.03, 0.25)
    return Deviation("", {f"{MRU}.scale_error": error}, {f"{BELIEF}.sensors.mru.scale_sigma": abs(error)})


def _high_pass(chance: Chance, _: Nominal) -> Deviation:
    period = chance.between(20.0, 80.0)
    told = {f"{BELIEF}.sensors.mru.high_pass_period": period}
    return Deviation("", {f"{MRU}.high_pass_period": period}, told)


def _mru_noise(chance: Chance, _: Nominal) -> Deviation:
    noise = {name: NOISES[name] * chance.between(1.5, 6.0) for name in ("noise", "rate_noise")}
    return Deviation(
        "",
        {f"{MRU}.{name}": value for name, value in noise.items()},
        {f"{BELIEF}.sensors.mru.{name}": value for name, value in noise.items()},
    )


def _depth_noise(chance: Chance, _: Nominal) -> Deviation:
    noise = NOISES["depth"] * chance.between(1.5, 6.0)
    return Deviation("", {f"{DEPTH}.noise": noise}, {f"{BELIEF}.sensors.depth.noise": noise})


def _mru_steps(chance: Chance) -> Settings:
    step = chance.one_of((0.001, 0.005, 0.01, 0.02, 0.05))
    return {f"{MRU}.resolution": step, f"{MRU}.rate_resolution": step if chance.happens(0.5) else 0.0}


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


_GEAR = ("encoder", "winch")
_DRUM = ("drum", "encoder", "winch")

DEVIATIONS = (
    Row("speed limits", ("winch",), _limits("speed", 0.4, (0.6, 1.0))),
    Row("acceleration limits", ("winch",), _limits("acceleration", 0.4, (0.5, 1.0))),
    Row("power limit", ("winch",), _power),
    Row("limits that fall", ("winch",), _drift("speed", "acceleration", low=0.4, high=0.9), slot="drift"),
    Row("lag", ("winch",), of_winch("time_constant", lambda c, n: {"time_constant": n.lag * c.spread(0.5, 2.5)})),
    Row(
        "delay", ("winch",), of_winch("command_delay", lambda c, n: {"command_delay": n.delay + c.between(-0.15, 0.2)})
    ),
    Row("delay jitter", ("winch",), with_nothing_to_tell(lambda c: {f"{WINCH}.command_jitter": c.spread(1e-3, 0.06)})),
    Row("gain", ("winch",), of_winch("speed_gain", lambda c, _: {"speed_gain": c.beside(0.75, 1.25, 0.03)})),
    Row("gain that drifts", ("winch",), _drift("gain", low=0.75, high=1.25), slot="drift"),
    Row("dead zone", ("winch",), of_winch("", lambda c, _: {"speed_deadband": c.spread(0.005, 0.06)})),
    Row("creep", ("winch",), of_winch("creep", lambda c, _: {"creep": c.sign() * c.spread(0.005, 0.05)})),
    Row("play", _GEAR, of_winch("", lambda c, _: {"encoder.backlash": c.spread(0.002, 0.03)})),
    Row(
        "encoder resolution",
        _GEAR,
        with_nothing_to_tell(lambda c: {f"{WINCH}.encoder.resolution": c.spread(0.002, 0.03)}),
    ),
    Row("encoder scale", _GEAR, _encoder_scale),
    Row("drum radius", _DRUM, of_winch("", lambda c, _: {"drum_radius_error": c.beside(-0.06, 0.06, 0.01, 0.0)})),
    Row(
        "cable stiffness", ("cable",), _shared(lambda c, n: {"cable.axial_stiffness": n.stiffness * c.spread(0.5, 1.8)})
    ),
    Row(
        "cable damping",
        ("cable",),
        _shared(lambda c, n: {"cable.internal_damping": n.stiffness * c.spread(1e-3, 3e-2)}),
    ),
    Row("unit size", ("cable",), _shared(_unit_size)),
    Row(
        "added mass",
        ("cable",),
        _shared(lambda c, n: {"unit.added_mass": 3 * [n.added_mass * c.beside(0.5, 2.0, 0.15)]}),
    ),
    Row("drag", ("cable",), _shared(lambda c, n: {"unit.drag_coefficient": 3 * [n.drag * c.spread(0.5, 4.0)]})),
    Row("MRU scale", ("mru",), _mru_scale),
    Row("MRU high-pass", ("mru",), _high_pass),
    Row("MRU noise", ("mru",), _mru_noise),
    Row(
        "MRU noise that is not white",
        ("mru",),
        that_cannot_be_told(
            lambda c: {f"{MRU}.wander": c.spread(0.01, 0.06), f"{MRU}.wander_time": c.spread(0.3, 6.0)}
        ),
        slot="wander",
    ),
    Row(
        "MRU wander",
        ("mru",),
        that_cannot_be_told(
            lambda c: {f"{MRU}.wander": c.spread(0.05, 0.6), f"{MRU}.wander_time": c.spread(30.0, 200.0)}
        ),
        slot="wander",
    ),
    Row("MRU quantisation", ("mru",), with_nothing_to_tell(_mru_steps)),
    Row(
        "MRU time offset",
        ("mru",),
        that_cannot_be_told(lambda c: {f"{MRU}.stamp_error": c.beside(-0.2, 0.3, 0.02, 0.0)}),
    ),
    Row(
        "depth scale",
        ("depth",),
        that_cannot_be_told(lambda c: {f"{DEPTH}.scale_error": c.beside(-0.1, 0.1, 0.01, 0.0)}),
    ),
    Row("depth noise", ("depth",), _depth_noise),
    Row(
        "depth quantisation",
        ("depth",),
        with_nothing_to_tell(lambda c: {f"{DEPTH}.resolution": c.one_of((0.01, 0.02, 0.05, 0.1))}),
    ),
    Row("fault", (), _fault, weight=4.0),
    *SEAS,
)
"""All that can differ. What a fault may be blamed on is its sensor."""
