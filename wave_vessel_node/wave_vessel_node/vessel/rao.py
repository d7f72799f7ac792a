"""Response amplitude operators (RAO) of a vessel: six motions per unit wave amplitude, by speed, heading and frequency.

Convention: e^{+i omega t}; a wave of unit amplitude cos(omega t - k x) at the reference point gives the motion
Re(H e^{i omega_e t}). The heading of the waves is relative to the bow: 0 following, pi/2 waves travelling to port, pi
head sea. Axes and signs: see `motion`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import scipy
from heave_node.files.plausible import ACCEPT, question, refusal
from heave_node.numerics.arrays import Array, ComplexArray
from heave_node.numerics.constants import STANDARD_GRAVITY
from numpy.typing import ArrayLike

from wave_vessel_node.vessel.motion import DEGREES_OF_FREEDOM

MIRROR = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
"""Factor of each motion of a symmetric ship when the waves come from the other side."""


class RaoError(ValueError):
    """RAOs that cannot be used; the message names file, place and what was expected."""


@dataclass(frozen=True)
class ResponseTable:
    """RAOs on a grid."""

    speed: Array  # forward speeds [m/s], shape (s,), rising
    # relative wave headings [rad], shape (h,), rising, 0 to pi (a symmetric ship, mirrored) or 0 to below 2 pi
    heading: Array
    frequency: Array  # wave frequency (not of encounter) [rad/s], shape (f,), rising
    response: ComplexArray  # shape (s, h, 6, f), [m/m] for surge, sway, heave and [rad/m] for roll, pitch, yaw
    warnings: tuple[str, ...] = ()  # what its reader found out or left out, one line each

    def __post_init__(self) -> None:
        shape = (self.speed.size, self.heading.size, 6, self.frequency.size)
        if self.response.shape != shape:
            raise RaoError(
                f"responses of shape {self.response.shape} where speeds, headings and frequencies require {shape}"
            )
        for name, values in (("speed", self.speed), ("heading", self.heading), ("frequency", self.frequency)):
            if not np.isfinite(values).all() or (np.diff(values) <= 0.0).any():
                raise RaoError(f"{name} must be finite and strictly increasing")
        if not np.isfinite(self.response).all():
            raise RaoError("responses must be finite")
        if self.frequency.size < 4 or self.frequency[0] <= 0.0:
            raise RaoError("expected at least 4 frequencies, all above 0")
        if self.heading[0] < -1e-6 or self.heading[-1] >= 2.0 * np.pi - 1e-6:
            reach = f"{self.heading[0]:g} to {self.heading[-1]:g}"
            hint = "2 pi is the same as 0" if self.heading[-1] < 6.3 else "are they in degrees?"
            raise RaoError(f"headings must lie from 0 to below 2 pi rad, they are {reach}: {hint}")
        if self.heading[0] > 1e-6 or self.heading[-1] < np.pi - 1e-3:
            given = ", ".join(f"{angle:.0f}" for angle in np.degrees(self.heading[:9]))
            raise RaoError(
                "headings must span 0 to pi (symmetric ship) or the full circle from 0: "
                f"these are {given} degrees; compute the others"
            )
        headings = self._headings()
        gap = int(np.argmax(np.diff(headings)))
        if headings[gap + 1] - headings[gap] > np.pi + 1e-3:
            raise RaoError(
                f"headings leave {headings[gap + 1] - headings[gap]:.3g} rad of the circle out after {headings[gap]:g}"
            )

    def at(self, frequency: ArrayLike, heading: ArrayLike, speed: float = 0.0) -> ComplexArray:
        """Return H at pairs of wave frequency and relative heading, shape (6, n).

        Splines in frequency (`between`) and heading, smooth in speed and held beyond its range. Above the highest
        frequency a motion falls as 1/omega^4; below the lowest it is held.

        Parameters
        ----------
        frequency : of the waves [rad/s], shape (n,)
        heading : of the waves relative to the bow [rad], one or shape (n,)
        speed : forward speed [m/s]
        """
        frequency, heading = np.atleast_1d(np.asarray(frequency, dtype=float)), np.asarray(heading, dtype=float)
        if heading.size and (heading == heading.flat[0]).all():
            return self._at_one(frequency, float(heading.flat[0]), speed)
        return self._at_each(frequency, np.broadcast_to(heading, frequency.shape), speed)

    def _at_one(self, frequency: Array, heading: float, speed: float) -> ComplexArray:
        """Return `at` for all frequencies from one `heading`: the spline in heading is then one weight for each."""
        knots = self._headings()
        unit = np.eye(len(knots))
        unit[-1] = unit[0] = unit[0] + unit[-1]  # the first heading is the last one too
        spline = scipy.interpolate.CubicSpline(knots, unit, axis=0, bc_type="periodic")
        by_heading = spline(np.mod(heading, 2.0 * np.pi))
        by_heading[-1] = 0.0
        by_speed = speed_weights(self.speed, speed)
        counts = np.flatnonzero(by_speed)
        found = [np.tensordot(by_heading, one, 1) for one in self._in_frequency(frequency, self.response[counts])]
        return np.asarray(np.tensordot(by_speed[counts], found, 1))

    def _at_each(self, frequency: Array, heading: Array, speed: float) -> ComplexArray:
        """Return `at` with a `heading` for each frequency."""
        knots, angle = self._headings(), np.mod(heading, 2.0 * np.pi)
        cell = np.clip(np.searchsorted(knots, angle, side="right") - 1, 0, knots.size - 2)
        powers = (angle - knots[cell])[:, None] ** np.arange(3, -1, -1)
        chosen = []
        for response in self._in_frequency(frequency, self.response):
            spline = scipy.interpolate.CubicSpline(knots, response, axis=0, bc_type="periodic")
            coefficients = np.ascontiguousarray(spline.c.transpose(3, 1, 2, 0))  # (n, cell, 6, 4)
            chosen.append(coefficients[np.arange(angle.size), cell])
        return np.asarray(
            np.einsum("ndp,np->dn", np.tensordot(speed_weights(self.speed, speed), chosen, axes=1), powers)
        )

    def _in_frequency(self, frequency: Array, responses: ComplexArray) -> Iterator[ComplexArray]:
        """Yield each of the `responses` (s, h, 6, f) all headings round at a `frequency` (n,), (headings, 6, n)."""
        inside = np.clip(frequency, self.frequency[0], self.frequency[-1])
        tail = above_the_table(frequency, self.frequency[-1])
        for response in responses:
            yield between(self.frequency, self._all_round(response), inside) * tail

    def _is_half(self) -> bool:
        return bool(self.heading[-1] <= np.pi + 1e-3)

    def _headings(self) -> Array:
        """Return the headings all the way round, closed at 2 pi."""
        if self._is_half():
            return np.concatenate((self.heading[:-1], [np.pi], 2.0 * np.pi - self.heading[-2::-1]))
        return np.append(self.heading, 2.0 * np.pi)

    def _all_round(self, response: ComplexArray) -> ComplexArray:
        if self._is_half():
            mirrored = response[-2::-1] * MIRROR[:, None]
            response = np.concatenate((response, mirrored))
            # in line with the waves a symmetric ship has no sway, roll or yaw: what rounding left would break the
            # period
            response[0] = response[-1] = 0.5 * (response[0] + response[-1])
            return response
        return np.concatenate((response, response[:1]))


def speed_weights(speeds: Array, speed: float) -> Array:
    """Return what each of the `speeds` of a table counts for at a `speed`, shape (s,): a cubic of continuous slope."""
    count = speeds.size
    if count == 1:
        return np.ones(1)
    speed = float(np.clip(speed, speeds[0], speeds[-1]))
    upper = int(np.clip(np.searchsorted(speeds, speed), 1, count - 1))
    h = speeds[upper] - speeds[upper - 1]
    x = (speed - speeds[upper - 1]) / h
    unit = np.eye(count)
    slope = np.gradient(unit, speeds, axis=0)
    weights = (1.0 - x) ** 2 * ((1.0 + 2.0 * x) * unit[upper - 1] + x * h * slope[upper - 1])
    return np.asarray(weights + x**2 * ((3.0 - 2.0 * x) * unit[upper] + (x - 1.0) * h * slope[upper]))


def between(omega: Array, response: ComplexArray, fine: Array) -> ComplexArray:
    """Return a complex `response`, shape (..., f) at `omega`, at the frequencies `fine`, between coarse ones too.

    Its phase turns fast where the body lies at a distance x from the origin, along the waves: by k x, k = omega^2/g.
    So x is fitted to the steps of the phase, each averaged over three and weighted by the response squared; cubic
    splines go through what is left, H exp(-i k x), which is slow, and passes through zero where the response does.
    """
    turns = response[..., 1:] * np.conj(response[..., :-1])
    padded = np.concatenate((turns[..., :1], turns, turns[..., -1:]), axis=-1)
    mean = padded[..., :-2] + padded[..., 1:-1] + padded[..., 2:]
    step, weight = np.diff(omega**2), np.abs(mean)
    total = np.sum(weight * step**2, axis=-1, keepdims=True)
    turned = np.sum(weight * step * np.unwrap(np.angle(mean)), axis=-1, keepdims=True)
    distance = np.divide(turned, total, out=np.zeros_like(turned), where=total > 0.0)  # x/g
    slow = scipy.interpolate.CubicSpline(omega, response * np.exp(-1j * distance * omega**2), axis=-1)
    return np.asarray(slow(fine) * np.exp(1j * distance * fine**2))


def above_the_table(frequency: Array, highest: float) -> Array:
    """Return by what motions fall above the `highest` frequency of a table, (highest/omega)^4; 1 below it.

    Parameters
    ----------
    frequency : of the waves [rad/s], shape (n,)
    highest : [rad/s]
    """
    return np.where(frequency > highest, (highest / frequency) ** 4, 1.0)


def encounter_frequency(frequency: ArrayLike, heading: ArrayLike, speed: float) -> Array:
    """Return omega_e = omega - omega^2 / g * speed * cos(heading) [rad/s]; negative where the ship overtakes the waves.

    Parameters
    ----------
    frequency : omega of the waves [rad/s], deep water
    heading : of the waves relative to the bow [rad]
    speed : forward speed [m/s]
    """
    frequency = np.asarray(frequency, dtype=float)
    return np.asarray(frequency - frequency**2 / STANDARD_GRAVITY * speed * np.cos(np.asarray(heading, dtype=float)))


_LONG_WAVES = 0.3
"""Frequency up to which waves (of 690 m or more) are long to a ship [rad/s]."""


def judged(path: Path, table: ResponseTable, questions: Sequence[str] = (), *, accept: bool) -> ResponseTable:
    """Return a table that is plausible, or accepted; what is implausible then joins its warnings.

    Parameters
    ----------
    path : of its file
    table : as read
    questions : of its reader, which come first
    accept : take what is implausible

    Raises RaoError for what is implausible and not accepted.
    """
    objections = [*questions, *response_questions(table)]
    if objections and not accept:
        raise RaoError(f"{path}: {refusal(objections, ACCEPT)}")
    return replace(table, warnings=(*table.warnings, *(f"{path}: {objection}" for objection in objections)))


def response_questions(table: ResponseTable) -> list[str]:
    """Return what is implausible about a table, one line each."""
    asked = [
        question("lowest wave frequency", float(table.frequency[0])),
        question("highest wave frequency", float(table.frequency[-1])),
    ]
    if table.frequency[0] <= _LONG_WAVES:
        long = np.abs(table.response[:, :, DEGREES_OF_FREEDOM.index("heave"), 0])
        worst = float(long.flat[np.argmax(np.abs(np.log(np.maximum(long, 1e-12))))])
        asked.append(question("heave in long waves", worst, f"at {table.frequency[0]:g} rad/s"))
    for motion, name in enumerate(DEGREES_OF_FREEDOM):
        size = np.abs(table.response[:, :, motion])
        at = np.unravel_index(np.argmax(size), size.shape)
        where = f"at {table.frequency[at[2]]:g} rad/s, heading {table.heading[at[1]]:.3g} rad"
        asked.append(question(f"{name} response", float(size[at]), where))
    return [objection for objection in asked if objection]
