"""What the core's gates and watches go by: parameters, assumed sensors, and the constants of what is no fault."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from heave_core.filter_table import MEASUREMENTS
from heave_core.look import padded
from heave_core.sense_table import READ, SENSORS, TRAVELS, ZeroKind
from heave_node.interface.sensors import LARGEST_PAYOUT, MRU, Water
from heave_node.interface.sensors import SENSORS as DELIVERING

from winch_controller_node.beliefs.beliefs import AS_READ, Correction
from winch_controller_node.core.estimation.loop_tick import TENSION_MEMORY
from winch_controller_node.design import seas
from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.interface.sensors import (
    KNOWN_SENSORS,
    LEVER_ARM_X,
    LEVER_ARM_Y,
    KnownSensors,
    SensorModelParameters,
    SensorsModelParameters,
    Zero,
)
from winch_controller_node.model.estimator import KalmanEstimator, row_with_differences

MEASURED = tuple(row for sensor in KnownSensors().by_name().values() for row in sensor.rows())
"""Measurements by their index in the core."""

ROWS = tuple(row.name for row in MEASURED)
"""Their names."""

OF_DRUM = {
    row.name for name, one in KnownSensors().by_name().items() if name not in ("mru", "encoder") for row in one.rows()
}
"""Measurements that feel where the drum is, beside its count: the boom tip heaves with the ship alone."""

INDEX = {name: index for index, name in enumerate(ROWS)}
"""Index of a measurement by its name."""

SENSOR = {name: index for index, name in enumerate(KNOWN_SENSORS)}
"""Index of a sensor by its name."""

ON_TICK = 1e-4
"""A stamp that is off its tick by a smaller share of the tick period is on it."""

TOLERANCES = ("stamp_tolerance", "frozen_samples", "stale_samples", "recover_samples", "encoder_step")
"""Parameters `health` that the gates go by."""

GATES = {
    "bad_in_a_row": 3,  # an alarm within three samples
    "rounding": 1e-6,
    "sameness_memory": 200.0,
    "in_steps": 1.5,  # two in a row, a minute or two ago
    "fewest_of_steps": 24,  # at a crest of the sea a sensor that reads in steps stands for long
    "longer": 2.0,
    "crest": 6.0,  # a quarter above the 2 sqrt(2) / (2 - sqrt(2)) of a parabola
    "few_steps": 4.0,
    "longest_wave": 20.0,
    "by_chance": 2e-4,  # three of a sensor that does not read in steps
    "fewest_noise": 30,
    "noise_updated": 10,
    "noise_unknown": 5.0,  # a sensor noisier than assumed must not be taken for one with an error
    "noise_worse": 2.0,
    "noise_median": 0.6745 * math.sqrt(20.0),
    "least_noise": 1e-4,
    "late": 1.5,  # half way to the next reading but one
}
"""Tolerances of all gates beside the parameters `health`: meanings and units are in the core's table, HEALTH."""

MAY_STAND = 3.0
"""Time for which a sensor may stand before its first step over `modes.settling_time`: a sea may rise in minutes."""

SAMENESS = {"first_sameness": 0.01, "part_sameness": 0.5}
"""Share of readings like the one before, at first: of a sensor without steps, of heave and rate of an MRU alone."""

LONGEST_PERIOD = 0.25
"""Between readings further apart [s] the sea itself is not smooth."""

STEPS = {
    "mru_step": 0.3,
    "sigmas": 8.0,
    "scatter": 0.2,  # a busy machine scatters arrivals so much
    "longest_gap": 0.5,
    "mean_time": 60.0,
    "largest_heave": 100.0,
    "near_mean": 0.25,
    "least_near": 0.1,
    "depth_step": 0.2,
    "depth_speed": 4.0,
    "like_scale": 0.1,  # one that makes a loop harmful
    "at_once": 1.5,
    "moving_speed": 0.05,
    "play": 0.03,
    "largest_play": 0.1,
    "beyond_play": 1.25,
    "known_unseen": 0.2,
    "release_time": 3.0,  # a large disc brake opens in a second
}
"""What is no jump: meanings and units are in the core's table, STEP_LIMITS."""

EXCLUDES_JUMPED = True
"""A sensor that has jumped as one of another scale does must agree with all others before it is used again."""

JUMP_SHOWN = 2.0
"""Time for which a subtracted jump of the encoder is shown [s]: diagnostics come once a second."""

TRAVEL_KNOWN = 10.0
"""Time over which the way that the drum should have turned is known [s]."""

BACK_TIME = 1.0
"""Time for which a sensor that was lost must deliver again [s]: before the boom tip counts as measured, and before a
fade-out ends that its loss has caused."""

WATCHES = {
    "memory": 20.0,
    "largest_nis": 25.0,  # a spike is no lasting error
    "inconsistent": 2.0,  # 1 is consistent
    "quiet": 0.4,
    "quiet_time": 60.0,
    # the adviser judges a minute, accepts an explanation after 10 s more, and a new assumption begins the count again
    "unexplained_time": 90.0,
    "tension_memory": TENSION_MEMORY,
    "moved": 0.01,
    "back_time": BACK_TIME,
}
"""How readings and tension are watched: meanings and units are in the core's table, WATCHES."""

FILTER_SHARE = 0.25
"""Time constant of the low-pass of the tension over that of the tension loop."""

ENCODER_ROW = "payout"
"""Readings of the encoder are not judged: the winch is identified by them."""


class SensorsWatched(NamedTuple):
    """The sensors that have a gate, by name."""

    in_use: dict[str, SensorModelParameters]  # whose readings the estimator takes
    watched: dict[str, SensorModelParameters]  # these, and those that are always watched

    @classmethod
    def of(cls, sensors: SensorsModelParameters) -> SensorsWatched:
        """Return those of the controller's parameters of its `sensors`."""
        in_use = sensors.in_use()
        return cls(
            in_use, {name: one for name, one in sensors.by_name().items() if name in in_use or one.is_always_watched}
        )


def tick_of(time: float, tick_period: float) -> tuple[int, float]:
    """Return the tick nearest to a `time` [s], and how much later than it that is, in ticks of a `tick_period` [s]."""
    tick = round(time / tick_period)
    offset = time / tick_period - tick
    return tick, offset if abs(offset) > ON_TICK else 0.0


def largest_step(noise: float, elapsed: float) -> float:
    """Return how far two depths may be apart [m] with an `elapsed` time between them [s] and `noise` of 1 sigma [m]."""
    return max(STEPS["depth_step"], STEPS["sigmas"] * noise) + STEPS["depth_speed"] * elapsed


def sense_design(
    design: ControllerDesign,
    sensors: SensorsWatched,
    estimator: KalmanEstimator,
    corrections: Mapping[str, Correction],
) -> dict[str, Any]:
    """Return the values of the core's SenseDesign.

    Parameters
    ----------
    design : the active one
    sensors : with their nominal noise and rates
    estimator : the filter that takes their readings
    corrections : assumed ones of readings, by sensor

    Raises ValueError for ticks that are too short for what must be kept.
    """
    parameters, dt, winch = design.parameters, design.tick_period, design.parameters.winch
    kept = max(2, round(TRAVEL_KNOWN / dt))
    if kept > TRAVELS:
        raise ValueError(
            f"encoder: {kept} ticks of the drum's way are kept, and at most {TRAVELS} fit: use longer ticks"
        )
    return {
        **{name: SENSOR[name] for name in ("mru", "depth", "encoder", "load_cell")},
        "excludes_jumped": EXCLUDES_JUMPED,
        "is_first_order": winch.law == "first_order",
        "levers": _levers(estimator),
        "tick_period": dt,
        "on_tick": ON_TICK,
        "static_tension": design.cable.static_tension,
        "stretch_per_payout": design.cable.static_tension / (design.cable.stiffness * design.length),
        "lag": winch.time_constant,
        "position_rate": winch.position_rate,
        "position_gain": winch.position_gain,
        "first_waves": seas.FIRST_WAVES,
        "refuted": seas.REFUTED,
        "health": GATES
        | {name: getattr(parameters.health, name) for name in TOLERANCES}
        | {"standing_time": MAY_STAND * parameters.modes.settling_time},
        "steps": STEPS | {"shown_ticks": round(JUMP_SHOWN / dt), "travel_ticks": kept},
        "watches": WATCHES
        | {
            "tension_share": dt / (FILTER_SHARE * parameters.tension.time_constant + dt),
            "coast_time": parameters.modes.coast_time,
        },
        "sea": seas.sea_design(design),
        "sensors": [
            _sensor(place, sensors, corrections, dt)
            | {"largest": _largest(place, Water(parameters.water_density, parameters.gravity))}
            for place in range(SENSORS)
        ],
        "measured": [_measured(place, sensors, estimator, dt) for place in range(MEASUREMENTS)],
    }


ZEROS = {
    Zero.OWN: ZeroKind.OWN_ZERO,
    Zero.FIRST_READING: ZeroKind.FIRST_READING,
    Zero.STATIC_TENSION: ZeroKind.STATIC_TENSION,
}


NOT_MEASURED = {"sensor": -1, "which": -1, "nominal": 1.0, "sigma": 1.0, "largest_stated": 1.0} | dict.fromkeys(
    ("has_noise", "is_judged", "stretches", "is_compared", "row", "change", "bend"), 0
)
"""A place of the core's measurements that no sensor has."""


def _sensor(place: int, sensors: SensorsWatched, corrections: Mapping[str, Correction], dt: float) -> dict[str, float]:
    """Return the values of the core's Sensor at a `place`; one that nobody knows is not watched."""
    name = KNOWN_SENSORS[place] if place < len(KNOWN_SENSORS) else ""
    known = sensors.watched.get(name) or (KnownSensors().by_name()[name] if name else None)
    correction, is_encoder = corrections.get(name, AS_READ), name == "encoder"
    period = dt if known is None else known.period(dt)
    return {
        "is_watched": name in sensors.watched or is_encoder,
        "is_used": name in sensors.in_use,
        "checks_frozen": not is_encoder,
        "sees_tip": known is not None and known.sees == "boom_tip",
        "zero": ZEROS[Zero.OWN if known is None else known.zero],
        "measured": 0 if known is None else INDEX[known.rows()[0].name],
        "sign": 1.0 if known is None else known.sign,
        "period": period,
        # the encoder is read a tick ago, in the state of the winch
        "latency": dt if is_encoder or known is None else known.age(),
        "longest_period": max(period, LONGEST_PERIOD),
        **SAMENESS,
        "scale": correction.scale,
        "offset": correction.offset,
        "delay": correction.delay,
    }


def _largest(place: int, water: Water) -> tuple[float, ...]:
    """Return the largest magnitudes that the numbers of a reading can have, of the sensor at a `place` of the core."""
    name = KNOWN_SENSORS[place] if place < len(KNOWN_SENSORS) else ""
    if name not in DELIVERING:
        return (LARGEST_PAYOUT if name == "encoder" else math.inf,) * READ
    largest = DELIVERING[name].largest_values(water)
    # a scalar reading is one of the values
    return largest[:READ] if name == MRU.name else (largest[KnownSensors().by_name()[name].component],) * READ


def _measured(place: int, sensors: SensorsWatched, estimator: KalmanEstimator, dt: float) -> dict[str, Any]:
    """Return the values of the core's Measured at a `place`."""
    name = ROWS[place] if place < len(ROWS) else ""
    found = [(owner, row) for owner, known in sensors.watched.items() for row in known.rows() if row.name == name]
    if not found:
        return NOT_MEASURED
    (owner, row), model = found[0], estimator.model
    sensor, known = sensors.watched[owner], estimator.measurements.get(name)
    has_noise = owner in sensors.in_use and sensor.zero is not Zero.STATIC_TENSION
    rows = row_with_differences(model.row(row.output) if known is None else known.row, model)
    return {
        "sensor": SENSOR[owner],
        "which": -1 if known is None else list(estimator.measurements).index(name),
        "has_noise": has_noise,
        "is_judged": has_noise and sensor.period(dt) <= LONGEST_PERIOD,
        "stretches": row.output == "unit_heave",
        "is_compared": name != ENCODER_ROW,
        "nominal": row.sigma,
        "largest_stated": row.largest_stated,
        "sigma": row.sigma if known is None else known.sigma,
        **{field: padded(one) for field, one in zip(("row", "change", "bend"), rows, strict=True)},
    }


def _levers(estimator: KalmanEstimator) -> tuple[int, ...]:
    """Return the indices of the lever arm's states in an `estimator`, -1 of one that it does not estimate."""
    states = list(estimator.model.state_names)
    return tuple(states.index(name) if name in states else -1 for name in (LEVER_ARM_X, LEVER_ARM_Y))


def second_design(estimator: KalmanEstimator, *, by_count: bool) -> dict[str, Any]:
    """Return the values of the core's Second: an `estimator` beside the active one, which may go `by_count`."""
    names, none = list(estimator.measurements), [""] * (MEASUREMENTS - len(ROWS))
    places = [names.index(name) if name in names else -1 for name in (*ROWS, *none)]
    sigmas = [known.sigma for known in estimator.measurements.values()]
    return {
        "goes_by_count": by_count,
        "levers": _levers(estimator),
        "which": tuple(places),
        "sigma": tuple(sigmas[place] if place >= 0 else 0.0 for place in places),
        "is_compared": tuple(not by_count or name in OF_DRUM for name in (*ROWS, *none)),
        **dict.fromkeys(("active", "second", "count"), 0.0),
    }
