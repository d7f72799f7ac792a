"""What the core's gates and watches go by: parameters, assumed sensors, and the constants of what is no fault."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from heave_core.filter_table import MEASUREMENTS
from heave_core.look import padded
from heave_core.sense_table import SENSORS, TRAVELS, ZeroKind

from winch_controller_node.beliefs.corrections import AS_READ, Correction
from winch_controller_node.core.estimation.consistency import (
    ENCODER_ROW,
    INCONSISTENT,
    LARGEST,
    MEMORY,
    QUIET,
    QUIET_TIME,
    UNEXPLAINED_TIME,
)
from winch_controller_node.core.estimation.tension import FILTER_SHARE, MOVED
from winch_controller_node.core.estimation.tension import MEMORY as TENSION_MEMORY
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
from winch_controller_node.parameters.laws import HealthParameters

MEASURED = tuple(row for sensor in KnownSensors().by_name().values() for row in sensor.rows())
"""Measurements by their index in the core."""

ROWS = tuple(row.name for row in MEASURED)
"""Their names."""

INDEX = {name: index for index, name in enumerate(ROWS)}
"""Index of a measurement by its name."""

SENSOR = {name: index for index, name in enumerate(KNOWN_SENSORS)}
"""Index of a sensor by its name."""

ON_TICK = 1e-4
"""A stamp that is off its tick by a smaller share of the tick period is on it."""

# readings that are no readings

BAD_IN_A_ROW = 3
"""Number of refused readings in a row that make a sensor lost: alarm within 3 samples."""

ROUNDING = 1e-6
"""Time by which an age may be beyond its limit [s]: clocks are sums of ticks."""

FIRST_SAMENESS, SAMENESS_MEMORY = 0.01, 200.0
"""Share of readings that are like the one before, of a sensor that does not read in steps, and readings over which that
of another is found."""

HEAVE_SAMENESS = 0.5
"""The same share of heave and rate of an MRU alone, at first: they may be read in steps."""

FEWEST_OF_STEPS, LONGER = 24, 2.0
"""Equal readings of a sensor that reads in steps that are none of a crest: so many, and this factor over its longest
run."""

BY_CHANCE = 2e-4
"""Probability of a run of equal readings below which a sensor is frozen: three of one that does not read in steps."""

# noise and rate

FEWEST = 30
"""Readings from which on noise is judged."""

UNKNOWN = 5.0
"""Noise until then, over the assumed one: a sensor noisier than assumed must not be taken for one with an error."""

WORSE = 2.0
"""Ratio to the assumed noise, or to that last reported, from which on noise is reported, once seen for long."""

UPDATED = 10
"""Readings from one judgement to the next."""

MEDIAN_OF_MAGNITUDE = 0.6745 * math.sqrt(20.0)
"""Median of the magnitude of the third difference of white noise, over its standard deviation."""

LONGEST_PERIOD = 0.25
"""Between readings further apart [s] the sea itself is not smooth."""

LATE = 1.5
"""Nominal intervals from which on a reading is late: half way to the next but one."""

NEGLIGIBLE = 1e-4
"""Nominal noise up to which a sensor is never reported as quieter than nominal, in the sensor's unit."""

# steps and jumps

LARGEST_STEP, SIGMAS = 0.3, 8.0
"""A step of an MRU's heave is more than the first [m], and than so many standard deviations of its noise."""

SCATTER = 0.2
"""Time by which a reading without a time may be late [s]; over it the rate is taken that is not measured."""

LONGEST_GAP = 0.5
"""Longest gap between samples of an MRU; after a longer one the comparison restarts [s]."""

MEAN_TIME = 60.0
"""Time over which the mean of the heave is taken [s]."""

LARGEST_HEAVE = 100.0
"""Heave that no ship reaches [m]."""

NEAR_MEAN, LEAST_NEAR = 0.25, 0.1
"""Distance of the mean to the one before within which an MRU is read again after a step: standard deviations, [m]."""

LARGEST_DEPTH_STEP, LARGEST_SPEED = 0.2, 4.0
"""A unit makes no step beyond the first [m], or SIGMAS of the sensor's noise, plus the second [m/s] times the time
since the last reading."""

LIKE_SCALE = 0.1
"""A jump of the depth by more than this share of it may be another scale, and one that makes a loop harmful."""

EXCLUDES_JUMPED = True
"""A sensor that has jumped as one of another scale does must agree with all others before it is used again."""

JUMP_SHOWN = 2.0
"""Time for which a subtracted jump of the encoder is shown [s]: diagnostics come once a second."""

AT_ONCE, TRAVEL_KNOWN = 1.5, 10.0
"""A reading that comes later than so many ticks after the last one is judged by all that the drum should have turned
meanwhile, as far as that is known, so long [s]."""

MOVING_SPEED, PLAY = 0.05, 0.03
"""A drum commanded faster than this [m/s] must show in the encoder, once that has taken up play and lag [m]."""

LARGEST_PLAY, BEYOND_PLAY = 0.1, 1.25
"""Play that a gear may be found to have [m], and the way of a drum that has turned round, over the play, which proves
the encoder frozen all the same."""

KNOWN_UNSEEN = 0.2
"""Share of the way that a drum has gone unseen by which it may be elsewhere than it was sent."""

BACK_TIME = 1.0
"""Time for which a sensor that was lost must deliver again [s]: before the boom tip counts as measured, and before a
fade-out ends that its loss has caused."""


class SensorsWatched(NamedTuple):
    """The sensors that have a gate, by name.

    Attributes
    ----------
    in_use : whose readings the estimator takes
    watched : these, and those that are always watched
    """

    in_use: dict[str, SensorModelParameters]
    watched: dict[str, SensorModelParameters]

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
    return max(LARGEST_DEPTH_STEP, SIGMAS * noise) + LARGEST_SPEED * elapsed


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
    states = list(design.model.state_names)
    return {
        **{name: SENSOR[name] for name in ("mru", "depth", "encoder", "load_cell")},
        "follows_sea": parameters.estimator.sea_adaptation,
        "excludes_jumped": EXCLUDES_JUMPED,
        "is_first_order": winch.law == "first_order",
        "levers": tuple(states.index(name) if name in states else -1 for name in (LEVER_ARM_X, LEVER_ARM_Y)),
        "tick_period": dt,
        "on_tick": ON_TICK,
        "static_tension": design.cable.static_tension,
        "stretch_per_payout": design.cable.static_tension / (design.cable.stiffness * design.length),
        "lag": winch.time_constant,
        "position_rate": winch.position_rate,
        "position_gain": winch.position_gain,
        "first_waves": seas.FIRST_WAVES,
        "refuted": seas.REFUTED,
        "health": _health(parameters.health),
        "steps": _steps(dt, kept),
        "watches": _watches(design),
        "sea": seas.sea_design(design),
        "sensors": [_sensor(place, sensors, corrections, dt) for place in range(SENSORS)],
        "measured": [_measured(place, sensors, estimator, dt) for place in range(MEASUREMENTS)],
    }


def _health(parameters: HealthParameters) -> dict[str, float]:
    names = ("stamp_tolerance", "frozen_samples", "stale_samples", "recover_samples", "encoder_step")
    return {
        **{name: getattr(parameters, name) for name in names},
        "bad_in_a_row": BAD_IN_A_ROW,
        "rounding": ROUNDING,
        "sameness_memory": SAMENESS_MEMORY,
        "fewest_of_steps": FEWEST_OF_STEPS,
        "longer": LONGER,
        "by_chance": BY_CHANCE,
        "fewest_noise": FEWEST,
        "noise_updated": UPDATED,
        "noise_unknown": UNKNOWN,
        "noise_worse": WORSE,
        "noise_median": MEDIAN_OF_MAGNITUDE,
        "least_noise": NEGLIGIBLE,
        "late": LATE,
    }


def _steps(dt: float, kept: int) -> dict[str, float]:
    return {
        "mru_step": LARGEST_STEP,
        "sigmas": SIGMAS,
        "scatter": SCATTER,
        "longest_gap": LONGEST_GAP,
        "mean_time": MEAN_TIME,
        "largest_heave": LARGEST_HEAVE,
        "near_mean": NEAR_MEAN,
        "least_near": LEAST_NEAR,
        "depth_step": LARGEST_DEPTH_STEP,
        "depth_speed": LARGEST_SPEED,
        "like_scale": LIKE_SCALE,
        "shown_ticks": round(JUMP_SHOWN / dt),
        "at_once": AT_ONCE,
        "travel_ticks": kept,
        "moving_speed": MOVING_SPEED,
        "play": PLAY,
        "largest_play": LARGEST_PLAY,
        "beyond_play": BEYOND_PLAY,
        "known_unseen": KNOWN_UNSEEN,
    }


def _watches(design: ControllerDesign) -> dict[str, float]:
    parameters, dt = design.parameters, design.tick_period
    return {
        "memory": MEMORY,
        "largest_nis": LARGEST,
        "inconsistent": INCONSISTENT,
        "quiet": QUIET,
        "quiet_time": QUIET_TIME,
        "unexplained_time": UNEXPLAINED_TIME,
        "tension_share": dt / (FILTER_SHARE * parameters.tension.time_constant + dt),
        "tension_memory": TENSION_MEMORY,
        "moved": MOVED,
        "coast_time": parameters.modes.coast_time,
        "back_time": BACK_TIME,
    }


ZEROS = {
    Zero.OWN: ZeroKind.OWN_ZERO,
    Zero.FIRST_READING: ZeroKind.FIRST_READING,
    Zero.STATIC_TENSION: ZeroKind.STATIC_TENSION,
}


NOT_MEASURED = {"sensor": -1, "which": -1, "nominal": 1.0, "sigma": 1.0} | dict.fromkeys(
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
        "first_sameness": FIRST_SAMENESS,
        "part_sameness": HEAVE_SAMENESS,
        "scale": correction.scale,
        "offset": correction.offset,
        "delay": correction.delay,
    }


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
        "sigma": row.sigma if known is None else known.sigma,
        **{field: padded(one) for field, one in zip(("row", "change", "bend"), rows, strict=True)},
    }
