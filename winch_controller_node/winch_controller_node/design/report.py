"""The design report: what the controller will do in its sea, before anyone starts it. Numbers, a table, and figures."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace

import numpy as np
from heave_node.kpi import kappa
from heave_node.numerics.arrays import Array, ComplexArray
from heave_node.numerics.linear_model import with_feedback

from winch_controller_node.design.bounds import BOUND_STEP, actuator_bound, boom_tip_realisation
from winch_controller_node.design.design import ControllerDesign, design_controller, error_of_two_states
from winch_controller_node.design.feasibility import (
    DRUM_RADIUS,
    WinchDemand,
    feasibility_table,
    format_feasibility,
    uncompensated_sigma,
)
from winch_controller_node.design.margins import (
    Margins,
    frequencies,
    margins,
    output_feedback_loop,
    state_feedback_loop,
)
from winch_controller_node.design.prediction import (
    ErrorCovariances,
    LoopPrediction,
    error_covariances,
    estimation_bound,
    predict_loop,
)
from winch_controller_node.model.lqr import DesignError
from winch_controller_node.model.regulator import full_gain, weighted_cost
from winch_controller_node.node_parameters import WinchControllerParameters

COMMAND_SIZES = (0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 20.0, 100.0)
"""Scales of the command along the trade-off curve [m/s]; a smaller scale is a larger weight."""

WINCH_LAGS = (0.05, 0.1, 0.15, 0.25, 0.4, 0.6, 1.0, 1.6, 2.5)
"""Lags of the winch along the bandwidth curve [s]."""

BISECTIONS = 12
"""Halvings of the search for the weight that gives a prescribed sigma."""

PRESCRIBED = 2.0
"""Unit sigma prescribed along the bandwidth curve, in that of the design."""

BOUND_DURATION = 400.0
"""Record over which the clairvoyant plans [s]."""

BOUND_RECORDS = 3
"""Records it plans over."""

POOR = 0.5
"""Relative error of two states above which a unit was not held: 3 t on 4,000 m (0.44) was, on 6,000 m (0.74) not."""

OF_DRAG = ("unit_heave", "unit_heave_rate", "unit_heave_acceleration", "tension")
"""Outputs that depend on drag, which the design linearises at small motion: with the winch locked the motion is not."""

DESIGNED_LAW = "lqg"
"""The law whose gains, margins and predictions a report gives: the estimate of all states and its feedback."""


@dataclass(frozen=True)
class TradeOff:
    """One point of a trade-off curve."""

    parameter: float  # scale of the command [m/s], or lag of the winch [s]
    unit_sigma: float  # predicted motion of the unit, 1 sigma [m]
    rate_sigma: float  # predicted payout rate, 1 sigma [m/s]
    acceleration_sigma: float  # predicted payout acceleration, 1 sigma [m/s^2]
    command_sigma: float  # of the set-point [m/s], the effort asked of the drive
    gain_norm: float  # square root of the sum of squared gains, the thesis's index (Eq. 6.18) [mixed units]


@dataclass(frozen=True, eq=False)
class DesignReport:
    """All that `heave design` says."""

    design: ControllerDesign  # what it is about
    prediction: LoopPrediction  # of the LQG loop, and of the delay-augmented LQR with all states known
    poles: ComplexArray  # discrete poles of the closed loop
    margins_state: Margins  # with all states known
    margins_output: Margins  # with the Kalman filter
    omegas: Array  # frequencies of the loop gain [rad/s]
    loop: ComplexArray  # loop gain with the Kalman filter
    uncompensated_sigma: float  # of the unit with the winch locked, drag linearised at that motion [m]
    s_est: float  # least unit sigma by sensors and delay [m]
    s_act: float  # least unit sigma by the winch's limits [m]
    kappa: float  # how far the LQG prediction is from both [-]
    power_mean: float  # mean of abs(T v) at static tension [W]
    power_significant: float  # 4 sigma of T v at static tension [W]
    weight_curve: tuple[TradeOff, ...]  # trade-off against command scale (thesis figs 6.18, 6.19)
    winch_curve: tuple[TradeOff, ...]  # trade-off against winch lag (thesis fig 6.25)
    feasibility: tuple[WinchDemand, ...]  # demand on the winch for seas around the design sea

    def table(self) -> str:
        """Return the report as text a person can read."""
        return "\n\n".join([_head(self), _demands(self), _predictions(self), _loop(self), _gains(self), _curves(self)])

    def values(self) -> dict[str, object]:
        """Return the report as plain values for a machine."""
        design = self.design
        return {
            "law": DESIGNED_LAW,
            "length_m": design.length,
            "a_s2": design.cable.a,
            "b_s": design.cable.b,
            "state_names": list(design.model.state_names),
            "gain": design.gain.tolist(),
            "poles": [[float(pole.real), float(pole.imag)] for pole in self.poles],
            "margins_state_feedback": _finite(asdict(self.margins_state)),
            "margins_output_feedback": _finite(asdict(self.margins_output)),
            "predicted_sigma": self.prediction.sigma,
            "predicted_command_sigma": self.prediction.command_sigma,
            "estimate_error": self.prediction.estimate_error,
            "uncompensated_sigma": self.uncompensated_sigma,
            "locked_sigma_small_motion": design.sigma,
            "s_est_m": self.s_est,
            "s_act_m": self.s_act,
            "kappa": self.kappa,
            "power_mean_w": self.power_mean,
            "power_significant_w": self.power_significant,
            "weight_curve": [asdict(point) for point in self.weight_curve],
            "winch_curve": [asdict(point) for point in self.winch_curve],
            "winch_knee_s": knee(self.winch_curve) if self.winch_curve else None,
            "feasibility": [asdict(row) for row in self.feasibility],
        }


def _finite(values: dict[str, float]) -> dict[str, float | None]:
    return {name: value if math.isfinite(value) else None for name, value in values.items()}


def design_report(
    parameters: WinchControllerParameters, *, tick_period: float, seed: int = 1, length: float | None = None
) -> DesignReport:
    """Design a controller and return its report.

    Parameters
    ----------
    parameters : of the controller
    tick_period : [s]
    seed : of the record the clairvoyant plans over
    length : deployed length [m]; None: that of the parameters

    Raises
    ------
    DesignError : what cannot be designed, in words.
    """
    design = design_controller(parameters, tick_period=tick_period, length=length)
    errors = error_covariances(design)
    prediction = predict_loop(design, design.gain, errors)
    omegas = frequencies(tick_period)
    loop = output_feedback_loop(design, design.gain, omegas)
    s_est = estimation_bound(design, errors)
    s_act = _actuator_bound(design, seed)
    power = design.cable.static_tension * prediction.sigma["payout_rate"]
    closed = with_feedback(design.model, design.gain)
    return DesignReport(
        design=design,
        prediction=prediction,
        poles=np.linalg.eigvals(closed.A).astype(np.complex128),
        margins_state=margins(omegas, state_feedback_loop(design, design.gain, omegas)),
        margins_output=margins(omegas, loop),
        omegas=omegas,
        loop=loop,
        uncompensated_sigma=_uncompensated(design),
        s_est=s_est,
        s_act=s_act,
        kappa=kappa(prediction.sigma["unit_heave"], s_est, s_act),
        power_mean=power * math.sqrt(2.0 / math.pi),
        power_significant=4.0 * power,
        weight_curve=weight_curve(design, errors),
        winch_curve=winch_curve(design, PRESCRIBED * prediction.sigma["unit_heave"]),
        feasibility=tuple(_feasibility(parameters)),
    )


def _uncompensated(design: ControllerDesign) -> float:
    given = design.parameters.cable_model
    if given.inertia > 0.0 and given.damping > 0.0:
        return design.sigma["unit_heave"]  # an identified cable is all that is known
    return uncompensated_sigma(design.parameters, design.length)


def _actuator_bound(design: ControllerDesign, seed: int) -> float:
    """Return the root mean square of the clairvoyant's bound over some records: rare high waves make it scatter."""
    parameters, bounds = design.parameters, []
    for record in range(BOUND_RECORDS):
        tip = boom_tip_realisation(
            parameters.sea, parameters.vessel, duration=BOUND_DURATION, step=BOUND_STEP, seed=seed + record
        )
        bounds.append(actuator_bound(design.cable, parameters.winch, tip, BOUND_STEP))
    return float(np.sqrt(np.mean(np.square(bounds))))


def _point(design: ControllerDesign, value: float, command_size: float, errors: ErrorCovariances) -> TradeOff:
    weights = replace(design.parameters.weights, command=command_size)
    gain = full_gain(design.model, weighted_cost(weights, design.model))
    prediction = predict_loop(design, gain, errors)
    return TradeOff(
        parameter=value,
        unit_sigma=prediction.sigma["unit_heave"],
        rate_sigma=prediction.sigma["payout_rate"],
        acceleration_sigma=prediction.sigma.get("payout_acceleration", math.nan),
        command_sigma=prediction.command_sigma,
        gain_norm=float(np.linalg.norm(gain)),
    )


def weight_curve(
    design: ControllerDesign, errors: ErrorCovariances, sizes: Sequence[float] = COMMAND_SIZES
) -> tuple[TradeOff, ...]:
    """Return predicted unit motion against winch use for growing command scales (thesis figs 6.18, 6.19).

    `sizes` are the scales [m/s], `errors` are `error_covariances(design)`.
    """
    return tuple(_point(design, size, size, errors) for size in sizes)


def winch_curve(
    design: ControllerDesign, unit_sigma: float, lags: Sequence[float] = WINCH_LAGS
) -> tuple[TradeOff, ...]:
    """Return what a prescribed `unit_sigma` [m] costs with a slower and slower winch (thesis fig 6.25, 6.3.5).

    For each lag [s] of `lags` the command scale is found with which `design` gives the prescribed sigma; lags at which
    none does are left out.
    """
    points = []
    for lag in lags:
        winch = replace(design.parameters.winch, time_constant=lag, position_rate=1.0 / lag)
        trial = design_controller(
            replace(design.parameters, winch=winch), tick_period=design.tick_period, length=design.length
        )
        point = _at_sigma(trial, lag, unit_sigma)
        if point is not None:
            points.append(point)
    return tuple(points)


def _at_sigma(design: ControllerDesign, value: float, unit_sigma: float) -> TradeOff | None:
    """Return the point of the weight curve with the prescribed sigma, by bisection; None: out of reach."""
    errors = error_covariances(design)
    low, high = math.log(COMMAND_SIZES[0] * 0.1), math.log(COMMAND_SIZES[-1] * 10.0)
    best = _point(design, value, math.exp(high), errors)
    if best.unit_sigma > unit_sigma:
        return None
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        point = _point(design, value, math.exp(middle), errors)
        if point.unit_sigma > unit_sigma:
            low = middle
        else:
            high, best = middle, point
    return best


def knee(curve: Sequence[TradeOff], share: float = 0.1) -> float:
    """Return the largest lag of the winch [s] whose command is at most `share` larger than that of the fastest winch.

    A quicker winch gains no more: the critical K of thesis fig 6.25 is its inverse.

    Raises DesignError for a curve without points.
    """
    if not curve:
        raise DesignError("no winch of the curve reaches the prescribed sigma")
    fastest = min(curve, key=lambda point: point.parameter)
    return max(point.parameter for point in curve if point.command_sigma <= (1.0 + share) * fastest.command_sigma)


def _feasibility(parameters: WinchControllerParameters) -> list[WinchDemand]:
    sea = parameters.sea
    heights = [round(factor * sea.significant_wave_height, 2) for factor in (0.5, 1.0, 1.5, 2.0)]
    periods = [max(1.0, round(sea.peak_period + shift, 2)) for shift in (-2.0, 0.0, 2.0)]
    return feasibility_table(parameters, heights, periods)


def _head(report: DesignReport) -> str:
    design = report.design
    sea, law = design.parameters.sea, design.parameters.law
    of_another = "" if law == DESIGNED_LAW else f" (the scenario uses law {law}: run it to see what that does)"
    return (
        f"Design of law {DESIGNED_LAW}{of_another}\n"
        f"Design at {design.length:g} m: a = {design.cable.a:.4g} s2, b = {design.cable.b:.4g} s, static tension "
        f"{design.cable.static_tension / 1e3:.1f} kN\n"
        f"{_of_two_states(design)}\n"
        f"Sea {sea.spectrum}, Hs {sea.significant_wave_height:g} m, Tp {sea.peak_period:g} s; winch "
        f"{design.parameters.winch.law}, "
        f"delay {design.parameters.winch.command_delay:g} s; sensors {', '.join(design.parameters.sensors.use)}"
    )


def _of_two_states(design: ControllerDesign) -> str:
    model = design.parameters.cable_model
    if model.inertia > 0.0 and model.damping > 0.0:
        return "a and b are given"
    error = error_of_two_states(design.parameters, design.length)
    limit = "" if error < POOR else ": too much, the rope resonates in more than one mode and compensation may do harm"
    return f"the two-state model of the rope differs by {100 * error:.0f} % from the full cable{limit}"


def _gains(report: DesignReport) -> str:
    design = report.design
    lines = ["state                        gain   1 sigma of its estimate"]
    lines += [
        f"{name:24s} {gain:9.4g}   {report.prediction.estimate_error[name]:.3g}"
        for name, gain in zip(design.model.state_names, design.gain, strict=True)
    ]
    return "\n".join(lines)


def _loop(report: DesignReport) -> str:
    moving = [pole for pole in report.poles if 1e-9 < abs(pole) < 1.0 - 1e-9]
    slowest = max(moving, key=abs)
    lines = [f"slowest closed-loop pole {abs(slowest):.5f} (1 is the edge of stability)"]
    for name, margin in (("all states known", report.margins_state), ("with the Kalman filter", report.margins_output)):
        lines.append(
            f"{name:22s}: gain margin {_factor(margin.gain_up)} (down {_factor(margin.gain_down)}), phase margin "
            f"{math.degrees(margin.phase):.0f} deg, delay margin {margin.delay:.3f} s, sensitivity peak "
            f"{margin.sensitivity_peak:.2f}"
        )
    return "\n".join(lines)


def _factor(gain: float) -> str:
    """Return a gain margin in words; 0 and infinity are no limit."""
    return f"x{gain:.3g}" if 0.0 < gain < math.inf else "unlimited"


def _predictions(report: DesignReport) -> str:
    sigma, off = report.prediction.sigma, report.design.sigma
    lines = ["1 sigma, SI units         compensated  winch locked"]
    locked = {name: f"{value:12.4g}" for name, value in off.items() if name not in OF_DRAG}
    locked["unit_heave"] = f"{report.uncompensated_sigma:12.4g}"
    lines += [f"{name:24s} {sigma[name]:12.4g}  {locked.get(name, '-'):>12s}" for name in sigma]
    lines.append(
        f"load heave {100.0 * sigma['unit_heave']:.2f} cm, with the winch locked "
        f"{100.0 * report.uncompensated_sigma:.1f} cm; least possible {100.0 * report.s_est:.2f} cm by sensors and "
        f"delay, {100.0 * report.s_act:.2f} cm by winch limits (kappa {report.kappa:.2f})"
    )
    lines.append(
        f"winch power at static tension: mean {report.power_mean / 1e3:.1f} kW, significant "
        f"{report.power_significant / 1e3:.1f} kW"
    )
    return "\n".join(lines)


def _curves(report: DesignReport) -> str:
    columns = "load cm   rate m/s   accel. m/s2  command   gain index"
    lines = [f"command scale m/s  {columns}"]
    lines += [_curve_row(point) for point in report.weight_curve]
    lines += ["", f"lag of winch s             {columns}"]
    lines += [_curve_row(point) for point in report.winch_curve]
    if report.winch_curve:
        lines.append(
            f"no benefit from a winch lag below {knee(report.winch_curve):g} s: it saves less than 10 % of the command"
        )
    return "\n".join(lines)


def _curve_row(point: TradeOff) -> str:
    return (
        f"{point.parameter:22.3g} {100.0 * point.unit_sigma:11.3f} {point.rate_sigma:10.3f} "
        f"{point.acceleration_sigma:13.3f} "
        f"{point.command_sigma:8.3f} {point.gain_norm:12.4g}"
    )


def _demands(report: DesignReport) -> str:
    return (
        "What the winch must deliver for full compensation, largest in 3 h, at static tension and a drum radius "
        f"of {DRUM_RADIUS:g} m.\nTo accelerate drum and motor (inertia J) at a, add torque J a / {DRUM_RADIUS:g} m.\n"
        + format_feasibility(report.feasibility)
    )
