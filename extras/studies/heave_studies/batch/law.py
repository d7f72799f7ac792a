"""The filter and the law of a design as matrices that do not change: what a controller is away from its limits.

The stationary Kalman filter of the sensors' pattern: the covariance before the readings of a tick goes to that of the
next by f(P) = A P (I + S P)^-1 A' + Q with S = H' R^-1 H. Such maps are of one form (A, S, Q) also one after the other,
so that twice as many ticks cost one more product (doubling; Chu, Fan and Lin, Linear Algebra Appl. 396 (2005) 55).

A screening covers the cases of which every parameter that it knows nothing of is at its default (`not_covered`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import reduce
from typing import NamedTuple

import numpy as np
from heave_bringup.nodes import NODES
from heave_bringup.scenarios import Scenario
from heave_core.sense_table import NOISE_READINGS
from heave_node.numerics.arrays import Array
from heave_node.parameters import Value, flatten
from heave_node.system_parameters import owned_names, system_names
from winch_controller_node.core.estimation.sense_design import GATES
from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.design.prediction import FilterModel, filter_gain, filter_model
from winch_controller_node.laws.mpc import MpcParameters, free_gain
from winch_controller_node.model.lqr import DesignError
from winch_controller_node.model.regulator import is_sea_state, is_sensor_state

from heave_studies.batch.kernel import DEPTH, ENCODER, MRU_HEAVE, MRU_RATE, NOISY, Control

COVERED: Mapping[str, tuple[str, ...]] = {
    "wave_vessel": (
        *("significant_wave_height", "peak_period", "spectrum", "peak_enhancement", "shape", "swell.", "spreading."),
        *("components", "direction", "ramp", "boom_tip_height", "vessel.", "course.heading", "course.speed", "filter."),
        *("spectrum_file", "spectrum_time", "accept_implausible", "preview.noise"),
        *("mru.rate", "mru.noise", "mru.rate_noise", "mru.wander", "mru.resolution", "mru.rate_resolution"),
        *("mru.high_pass_period", "mru.scale_error", "mru.latency"),
    ),
    "cable_sim": (
        *("length", "segments", "current", "current_profile.", "water_density", "gravity", "surface", "cable."),
        *("unit.", "seabed.", "boom_tip_height", "linear.", "sensors.depth.rate", "sensors.depth.latency"),
        *("sensors.depth.noise", "sensors.velocity.", "sensors.imu.", "sensors.usbl.", "sensors.load_cell."),
    ),
    "virtual_winch": (
        *("time_constant", "command_delay", "speed_limit", "acceleration_limit", "stop_deceleration", "payout_minimum"),
        *("payout_maximum", "power_limit", "rated_pull", "hauling_speed_share", "hauling_acceleration_share"),
        *("command_timeout", "supervision_time", "encoder.resolution"),
    ),
    "winch_controller": (
        *("law", "lqg.", "mpc.", "industrial.", "feedforward.", "weights.", "estimator.", "length", "water_density"),
        *("gravity", "boom_tip_height", "cable.", "unit.", "winch.time_constant", "winch.command_delay"),
        *("winch.speed_limit", "winch.acceleration_limit", "winch.payout_minimum", "winch.payout_maximum"),
        *("winch.power_limit", "winch.disturbance", "sea.", "vessel.", "sensors.", "limits.", "guard.", "lag."),
        *("modes.settling_time", "modes.fade_in_time", "modes.fade_out_time", "modes.coast_time", "modes.resume"),
        *("tension.", "envelope.", "alarms.", "entry.", "move.", "operator.", "health."),
    ),
}
"""Parameters by node that a screening covers; a group ends with a point."""

UNBELIEVED = (
    *("system.linear.", "system.sensors.mru.latency", "system.sensors.velocity.", "system.sensors.imu."),
    "system.sensors.load_cell.",
)
"""Words in which ship and controller may differ: those that no screened law takes, and a latency that stamps tell."""

LAWS = ("off", "lqg", "mpc")
"""Laws that are u = -G x away from their limits, or hold the winch."""


def not_covered(scenario: Scenario) -> str:
    """Return why no screening covers a `scenario`, in words; "" where one does."""
    law = scenario.parameters["winch_controller"].law
    if law not in LAWS:
        return f"law {law}"
    own = {node.name: flatten(scenario.parameters[node.name]) for node in NODES}
    for node, covered in COVERED.items():
        usual = flatten(type(scenario.parameters[node])())
        for name, value in own[node].items():
            if value != usual[name] and not any(_covers(word, name) for word in covered):
                return f"{node}.{name} = {value}"
    return _differing(own)


def _covers(word: str, name: str) -> bool:
    return name.startswith(word) if word.endswith(".") else name == word


def _differing(own: Mapping[str, Mapping[str, Value]]) -> str:
    """Return which node assumes another system than the owner of a parameter: the adviser would find out."""
    system: dict[str, Value] = {}
    for node, values in own.items():
        system |= {name: values[mine] for name, mine in owned_names(node, values).items()}
    for node, values in own.items():
        for name, mine in system_names(node, values).items():
            if values[mine] != system[name] and not name.startswith(UNBELIEVED):
                return f"{node}.{mine} = {values[mine]}, {name} = {system[name]}"
    return ""


READINGS = {"mru_heave": MRU_HEAVE, "mru_heave_rate": MRU_RATE, "unit_heave": DEPTH, "payout": ENCODER}
"""Measurements that the kernel gives, by name."""

MPC = "mpc"
DOUBLINGS = 24
"""Twice as many ticks each: 10 days of a tick of 50 ms."""
LEVEL_STEP = 0.2
"""Change of the logarithm of a noise, or of the height of the sea, over which the gains are taken to be straight."""
SETTLED = 1e-10
"""Change of the covariance over a doubling, relative, at which it is stationary."""


class _Map(NamedTuple):
    """A map of covariances P -> A P (I + S P)^-1 A' + Q."""

    A: Array
    S: Array
    Q: Array

    def then(self, other: _Map) -> _Map:
        """Return the map of this one and the `other` after it."""
        # A_2 (I + Q_1 S_2)^-1, and S_2 (I + Q_1 S_2)^-1
        ahead = np.linalg.solve((np.eye(len(self.Q)) + self.Q @ other.S).T, np.hstack((other.A.T, other.S))).T
        later, informed = np.split(ahead, 2)
        Q = other.Q + later @ self.Q @ other.A.T
        S = self.S + self.A.T @ informed @ self.A
        return _Map(later @ self.A, 0.5 * (S + S.T), 0.5 * (Q + Q.T))


def stationary_gains(model: FilterModel) -> list[Array]:
    """Return the gain of each tick of the pattern of a `model`, shape (n, m) for its m readings.

    Raises DesignError where the covariance does not settle.
    """
    ticks = list(zip(model.rows, model.variances, strict=True))
    maps = [_Map(model.A, rows.T @ (rows / np.reshape(variances, (-1, 1))), model.Q) for rows, variances in ticks]
    whole = reduce(_Map.then, maps)
    for _ in range(DOUBLINGS):
        before, whole = whole.Q, whole.then(whole)
        if not np.isfinite(whole.Q).all():
            break
        if np.abs(whole.Q - before).max() <= SETTLED * np.abs(whole.Q).max():
            return _gains(model, whole.Q)
    raise DesignError("the covariance of the estimate does not converge: the sensors do not determine the state")


def _gains(model: FilterModel, P: Array) -> list[Array]:
    """Return the gains of a pattern that begins with covariance P before its first readings."""
    gains = []
    for rows, variances in zip(model.rows, model.variances, strict=True):
        gains.append(filter_gain(P, rows, variances) if len(rows) else np.zeros((len(P), 0)))
        P = model.A @ (P - gains[-1] @ rows @ P) @ model.A.T + model.Q
    return gains


def law_gain(design: ControllerDesign) -> Array | None:
    """Return G of the law that a `design` names, u = -G x, shape (n,); None where it has none away from its limits."""
    law, parameters = design.parameters.law, design.parameters
    if law == "lqg":
        return design.gain
    mpc: MpcParameters = getattr(parameters, MPC)  # one group for each law that is there
    return free_gain(design.model, mpc) if law == MPC and mpc.preview_time == 0.0 else None


def control_of(design: ControllerDesign, gain: Array) -> Control:
    """Return the filter of a `design` and the law of a `gain` as the kernel takes them.

    Raises DesignError where the covariance does not settle.
    """
    model = filter_model(design)
    n, order, pattern = len(model.A), design.model.order, len(model.rows)
    higher = np.zeros_like(model.Q)
    higher[:order, :order] = math.expm1(2.0 * LEVEL_STEP) * design.sea_noise
    cases = [model, *(_noisier(model, reading) for reading in NOISY), replace(model, Q=model.Q + higher)]
    rows, gains = np.zeros((4, n)), np.zeros((len(cases), pattern, 4, n))
    for case, one in enumerate(cases):
        for phase, found in enumerate(stationary_gains(one)):
            for column, name in enumerate(model.names[phase]):
                rows[READINGS[name]] = model.rows[phase][column]
                gains[case, (phase + 1) % pattern, READINGS[name]] = found[:, column]
    by_level = (gains[1:] - gains[0]) / LEVEL_STEP
    command, law, of_sea = np.zeros(n), np.zeros(n), np.zeros(n)
    command[:order], law[:order] = design.model.B[:, 0], gain
    of_sea[[design.model.state(name) for name in design.sea_states]] = 1.0
    unit = design.model.state("unit_heave"), design.model.state("unit_heave_rate")
    return Control(np.ascontiguousarray(model.A.T), command, rows, gains[0], by_level, law, of_sea, unit)


def _noisier(model: FilterModel, reading: int) -> FilterModel:
    """Return a `model` of which a `reading` has more noise, by LEVEL_STEP."""
    more = [[math.exp(2.0 * LEVEL_STEP * (READINGS[name] == reading)) for name in names] for names in model.names]
    return replace(model, variances=[v * np.array(f) for v, f in zip(model.variances, more, strict=True)])


def noises_seen(values: Array, nominal: float) -> Array:
    """Return the logarithm of the noise that the filter assumes at each of some readings, over the `nominal` one (n,).

    It is the larger one of the nominal and that of the third differences of the last readings, by their median
    (`noise.cpp` of the core, from which window and steps are).

    Parameters
    ----------
    values : readings of a sensor one after the other, shape (n,)
    nominal : standard deviation of their noise, above 0
    """
    steps = np.abs(np.diff(values, 3))
    ends = np.arange(GATES["fewest_noise"], len(steps) + 1, GATES["noise_updated"], dtype=int)
    medians = [np.median(steps[:end]) for end in ends[ends < NOISE_READINGS]]
    if len(steps) >= NOISE_READINGS:
        windows = np.lib.stride_tricks.sliding_window_view(steps, NOISE_READINGS)
        whole = windows[ends[ends >= NOISE_READINGS] - NOISE_READINGS]
        middle = NOISE_READINGS // 2
        medians += np.partition(whole, (middle - 1, middle))[:, middle - 1 : middle + 1].mean(axis=1).tolist()
    seen = np.array([nominal, *np.array(medians) / GATES["noise_median"]])
    newest = np.searchsorted(ends, np.arange(len(values)) - 2, side="right")
    return np.asarray(np.log(np.maximum(seen / nominal, 1.0))[newest])


def settling_share(design: ControllerDesign, gain: Array, time: float) -> float:
    """Return what a `time` [s] under the `gain` of a `design` leaves of the slowest motion of unit and winch [-]."""
    model = design.model
    keep = [i for i, name in enumerate(model.state_names) if not (is_sea_state(name) or is_sensor_state(name))]
    closed = (model.A - np.outer(model.B[:, 0], gain))[np.ix_(keep, keep)]
    return float(np.abs(np.linalg.eigvals(closed)).max() ** (time / design.tick_period))
