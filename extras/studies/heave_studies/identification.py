"""Identification of the two-state cable from a response (thesis 6.2.3): least squares.

Models: a x'' + b x' + x = e (Eq. 6.2) and a x'' + b x' abs(x') + x = e (Eq. 6.3), with e = boom-tip heave less payout.
Besides a and b the start of the record and the mean of the sensor are found, so that any piece of a recording will do.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from cable_sim_node.vertical.axial import simulate_axial
from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import kernel
from heave_node.numerics.kinematics import smooth_ramp
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline
from scipy.optimize import least_squares
from winch_controller_node.design.bounds import boom_tip_realisation
from winch_controller_node.design.design import assumed_cable, assumed_plant
from winch_controller_node.node_parameters import WinchControllerParameters


@kernel
def respond(a: float, b: float, x: float, v: float, e: Array, e_middle: Array, h: float, is_quadratic: bool) -> Array:
    """Return x at each sample, shape (N,), by the classical Runge-Kutta method.

    Parameters
    ----------
    a, b : of the model; x, v : start [m], [m/s]
    e : outlet motion (boom-tip heave less payout) at the samples, shape (N,); e_middle : between them, shape (N-1,) [m]
    h : sample period [s]
    is_quadratic : drag b v abs(v) instead of b v
    """
    n = len(e)
    out, slopes = np.empty(n), np.zeros((4, 2))
    for k in range(n):
        out[k] = x
        if k == n - 1:
            break
        for stage in range(4):
            outlet = e[k] if stage == 0 else e[k + 1] if stage == 3 else e_middle[k]
            step = 0.0 if stage == 0 else h if stage == 3 else 0.5 * h
            at, rate = x + step * slopes[stage - 1, 0], v + step * slopes[stage - 1, 1]
            drag = rate * abs(rate) if is_quadratic else rate
            slopes[stage, 0], slopes[stage, 1] = rate, (outlet - at - b * drag) / a
        x += h / 6.0 * (slopes[0, 0] + 2.0 * slopes[1, 0] + 2.0 * slopes[2, 0] + slopes[3, 0])
        v += h / 6.0 * (slopes[0, 1] + 2.0 * slopes[1, 1] + 2.0 * slopes[2, 1] + slopes[3, 1])
    return out


CONVERGED = 1e-9
"""Relative change of the sum of squares with which the fit ends."""
SMALLEST_RECORD = 50
POOR_FIT = 0.7
"""Fit below which a and b are not worth much."""


class IdentificationError(ValueError):
    """A response from which nothing can be identified; the message says why."""


@dataclass(frozen=True)
class Fitted(ABC):
    """A model that was fitted to the load's heave."""

    drag: str  # "linear" (Eq. 6.2) or "quadratic" (Eq. 6.3)
    fit: float  # 1 - norm(residual)/norm(response about its mean) [-]; 1 is perfect
    time: Array  # of the record [s]
    measured: Array  # the record [m]
    model: Array  # the model's answer [m]

    @abstractmethod
    def summary(self) -> str:
        """Return the result in lines for people."""


@dataclass(frozen=True)
class Identification(Fitted):
    """What was found."""

    a: float  # [s^2]
    b: float  # [s], or [s^2/m] where drag is quadratic
    covariance: Array  # of (a, b), shape (2, 2); it allows for the time correlation of the residual
    residual_sigma: float  # [m]
    iterations: int  # steps taken
    note: str = ""  # reservation about the figures, in words; empty: none

    def summary(self) -> str:
        """Return the result in two lines, and the note."""
        unit = "s" if self.drag == "linear" else "s2/m"
        sigma = np.sqrt(np.diag(self.covariance))
        return (
            f"{self.drag} drag: a = {self.a:.5g} +- {sigma[0]:.2g} s2, b = {self.b:.5g} +- {sigma[1]:.2g} {unit}\n"
            f"fit {100.0 * self.fit:.2f} %, residual {100.0 * self.residual_sigma:.3g} cm, {self.iterations} iterations"
            + (f"\n{self.note}" if self.note else "")
        )

    def values(self) -> dict[str, object]:
        """Return the numbers for a machine."""
        return {
            "drag": self.drag,
            "a": self.a,
            "b": self.b,
            "covariance": self.covariance.tolist(),
            "fit": self.fit,
            "residual_sigma_m": self.residual_sigma,
            "iterations": self.iterations,
            "note": self.note,
        }


def identify(
    time: ArrayLike,
    boom_tip_heave: ArrayLike,
    unit_heave: ArrayLike,
    *,
    payout: ArrayLike | None = None,
    drag: str = "linear",
    guess: tuple[float, float] | None = None,
    starts_at_rest: bool = False,
) -> Identification:
    """Find a and b of the two-state cable from a response.

    Parameters
    ----------
    time : equally spaced samples [s]
    boom_tip_heave : [m], positive up
    unit_heave : [m], positive up, about any mean
    payout : [m], positive lowers the unit; None: winch locked
    drag : "linear" or "quadratic"
    guess : a and b to begin with; None: the best of a coarse search
    starts_at_rest : the unit rests at its mean at the first sample (as the thesis assumes); False finds
        its motion there

    Raises
    ------
    IdentificationError : a record that is too short, uneven, not finite or without motion; or no convergence.
    """
    t, tip, unit = (np.asarray(values, dtype=float) for values in (time, boom_tip_heave, unit_heave))
    paid = np.zeros_like(tip) if payout is None else np.asarray(payout, dtype=float)
    _check_record(t, tip, unit, paid)
    if drag not in ("linear", "quadratic"):
        raise IdentificationError(f"drag must be linear or quadratic; got {drag!r}")
    problem = _Problem(t, tip - paid, unit, drag == "quadratic", starts_at_rest)
    return problem.fitted(problem.start(guess), drag)


def _check_record(t: Array, tip: Array, unit: Array, paid: Array) -> None:
    if not t.ndim == 1 or not t.shape == tip.shape == unit.shape == paid.shape:
        raise IdentificationError(
            f"time, boom tip, payout and unit must be series of one length; got {t.shape}, {tip.shape}, "
            f"{paid.shape}, {unit.shape}"
        )
    if len(t) < SMALLEST_RECORD:
        raise IdentificationError(f"{len(t)} samples are too few: give {SMALLEST_RECORD} or more")
    if not all(np.all(np.isfinite(values)) for values in (t, tip, unit, paid)):
        raise IdentificationError("the record holds a value that is not finite: cut it there, or fill the gap")
    steps = np.diff(t)
    if steps.min() <= 0.0 or np.ptp(steps) > 1e-3 * steps.mean():
        raise IdentificationError("the samples must be equally spaced in rising time: resample the record first")
    if np.std(tip - paid) < 1e-6 or np.std(unit) < 1e-9:
        raise IdentificationError("boom tip or unit moves too little to identify anything: record a rougher sea")


class _Problem:
    """Residual of one record; theta = a, b, mean of the sensor, start heave, start rate."""

    def __init__(self, time: Array, outlet: Array, unit: Array, is_quadratic: bool, starts_at_rest: bool) -> None:
        self.time, self.unit = time, unit
        self._period = float(time[1] - time[0])
        self._outlet = np.ascontiguousarray(outlet)
        middle = CubicSpline(time, outlet)(time[:-1] + 0.5 * self._period)
        self._middle = np.ascontiguousarray(middle)
        self._is_quadratic = is_quadratic
        self.free = 3 if starts_at_rest else 5

    def residual(self, theta: Array) -> Array:
        """Return what the model at theta, shape (3,) or (5,), leaves of the record, shape (N,)."""
        a, b, mean, x, v = np.concatenate((theta, np.zeros(5 - len(theta))))
        model: Array = respond(a, b, x, v, self._outlet, self._middle, self._period, self._is_quadratic)
        return np.asarray(self.unit - mean - model)

    def cost(self, theta: Array) -> float:
        """Return the sum of squares, infinite where the model runs away or its numbers make no sense."""
        if theta[0] <= 0.0 or theta[1] < 0.0:
            return math.inf
        with np.errstate(over="ignore", invalid="ignore"):
            total = float(np.sum(self.residual(theta) ** 2))
        return total if math.isfinite(total) else math.inf

    def start(self, guess: tuple[float, float] | None) -> Array:
        """Return where to begin: `guess`, or the best of a coarse grid."""
        rest = np.zeros(self.free - 2)
        rest[0] = self.unit.mean() - self._outlet.mean()
        if guess is not None:
            if not (guess[0] > 0.0 and guess[1] >= 0.0):
                raise IdentificationError(f"the guess must have a > 0 and b >= 0; got {guess[0]:g}, {guess[1]:g}")
            return np.array([*guess, *rest])
        shortest = self._period**2
        grid = [
            np.array([a, b * math.sqrt(a), *rest])
            for a in np.geomspace(max(0.01, shortest), 60.0, 48)
            for b in (0.02, 0.1, 0.5)
        ]
        return min(grid, key=self.cost)

    def fitted(self, start: Array, drag: str) -> Identification:
        """Return the identification, by scipy's trust region within a > 0, b >= 0 from a `start`."""
        if not math.isfinite(self.cost(start)):
            raise IdentificationError("the model diverges from the first guess: choose another guess")
        lowest = np.full(self.free, -np.inf)
        lowest[:2] = np.finfo(float).tiny, 0.0
        with np.errstate(over="ignore", invalid="ignore"):
            found = least_squares(self.residual, start, bounds=(lowest, np.inf), x_scale="jac", ftol=CONVERGED)
        if not found.success:
            raise IdentificationError(f"no convergence in {found.nfev} steps: the response is not that of a cable")
        residual, information = found.fun, found.jac.T @ found.jac
        variance = float(residual @ residual) / max(len(residual) - self.free, 1)
        whole = np.asarray(np.linalg.pinv(information), dtype=np.float64) * variance * _correlation_factor(residual)
        swing = float(np.linalg.norm(self.unit - self.unit.mean()))
        fit = 1.0 - float(np.linalg.norm(residual)) / swing
        return Identification(
            drag=drag,
            a=float(found.x[0]),
            b=float(found.x[1]),
            covariance=whole[:2, :2],
            fit=fit,
            residual_sigma=math.sqrt(variance),
            iterations=int(found.njev),
            time=self.time,
            measured=self.unit,
            model=self.unit - residual,
            note=f"poor fit: the model explains {100.0 * fit:.0f} % of the motion" if fit < POOR_FIT else "",
        )


def _correlation_factor(residual: Array) -> float:
    """Return by how much time correlation of the residual multiplies the variances (Bartlett's window)."""
    n = len(residual)
    about_mean = residual - residual.mean()
    spectrum = np.abs(np.fft.rfft(about_mean, 2 * n)) ** 2
    covariance = np.fft.irfft(spectrum)[:n]
    if covariance[0] <= 0.0:
        return 1.0
    lags = np.arange(1, max(2, n // 10))
    weights = 1.0 - lags / (lags[-1] + 1.0)
    # sensitivities swing as the residual does: what counts is the sum of squared correlations
    return 1.0 + 2.0 * float(np.sum(weights * (covariance[lags] / covariance[0]) ** 2))


DURATION = 600.0
SAMPLE_PERIOD = 0.1
RAMP = 30.0
SHOWN = 200.0


def identify_simulated(parameters: WinchControllerParameters, *, drag: str = "linear", seed: int = 1) -> Identification:
    """Identify a and b as thesis 6.2.3 does: from the axial cable's response to a realisation of the design sea.

    The record of 600 s starts at rest and grows over 30 s; the winch is locked.

    Parameters
    ----------
    parameters : of plant and sea
    drag : "linear" or "quadratic"
    seed : of the sea

    Raises IdentificationError, or the AxialError of a response that cannot be simulated.
    """
    length, plant = parameters.length, assumed_plant(parameters)
    tip = boom_tip_realisation(parameters.sea, parameters.vessel, duration=DURATION, step=SAMPLE_PERIOD, seed=seed)
    time = SAMPLE_PERIOD * np.arange(len(tip))
    tip = tip * np.array([smooth_ramp(float(t), RAMP)[0] for t in time])
    response = simulate_axial(plant.line(length), length, tip, SAMPLE_PERIOD, segments=20, largest_step=0.025)
    guess = assumed_cable(parameters, length)
    found = identify(
        time, tip, response.unit_heave, drag=drag, guess=(guess.a, max(guess.b, 0.01)), starts_at_rest=True
    )
    slack = float(np.mean(response.least_tension <= 0.0))
    if slack > 0.0:
        note = f"the cable was slack {100.0 * slack:.1f} % of the time: no linear model is valid there;  {found.note}"
        return replace(found, note=note.rstrip("; "))
    return found


def draw_identification(found: Fitted, path: Path) -> None:
    """Draw what was `found` to `path`: the last 200 s of response, model and residual (thesis 6.11 to 6.13)."""
    from matplotlib.figure import Figure  # noqa: PLC0415  # heavy, and only for who draws

    shown: Array = found.time >= found.time[-1] - SHOWN
    figure = Figure(figsize=(8.0, 5.0), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    above.plot(found.time[shown], found.measured[shown], label="response")
    above.plot(found.time[shown], found.model[shown], "--", label=f"model, {found.drag} drag")
    above.set_title(found.summary().replace("\n", "; "), fontsize=9)
    above.set_ylabel("load heave [m]")
    above.legend()
    below.plot(found.time[shown], (found.measured - found.model)[shown], color="0.3")
    below.set_ylabel("residual [m]")
    below.set_xlabel("time [s]")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)
