"""The command governor: no command leaves that would take the winch beyond its limits.

The command of a tick acts after the delay; what counts is the winch's state then, which the model predicts from the
commands already on their way. The governed command is what the estimator is given, so that it never predicts a motion
that the winch cannot make: that is all the anti-windup a state-feedback law needs.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel
from heave_node.numerics.linear_sampling import discretise

from winch_controller_node.laws.parts.winch_limits import WinchLimits
from winch_controller_node.model.blocks import winch_block
from winch_controller_node.motion.trajectory import approach_speed
from winch_controller_node.parameters.model import WinchModelParameters

SPEED, ACCELERATION, PAYOUT, POWER, TENSION, FADE = "speed", "acceleration", "payout", "power", "tension", "fade_out"


class GovernedCommand(NamedTuple):
    """What came out.

    Attributes
    ----------
    value : command in the terms of the linear model: the estimator's input
    active : names of the limits that shaped it
    sent : the same for the winch, whose acceleration limiter acts within the tick, and which has a gain of its own
    """

    value: float
    active: tuple[str, ...]
    sent: float


class SpeedServo:
    """The servo over one tick, with and without its acceleration limiter.

    A set-point that is held over a tick asks for the most acceleration at its start and for less towards its end. The
    limit counts for the speed gained over the tick: to gain limit * dt, the set-point must be further off than the
    linear servo needs, and the winch's own limiter then keeps the acceleration even.

    Parameters
    ----------
    time_constant : T [s]; acceleration : limit [m/s^2]; dt : tick period [s]
    """

    def __init__(self, time_constant: float, acceleration: float, dt: float) -> None:
        self._lag = time_constant
        self._acceleration = acceleration
        self._dt = dt
        self.linear_step = acceleration * dt / -math.expm1(-dt / time_constant)
        """Largest distance of a command from the speed, in the linear model [m/s]."""
        self.linear_acceleration = self.linear_step / time_constant
        """Acceleration at the start of a tick under that command, in the linear model [m/s^2]."""

    def set_point(self, value: float, rate: float) -> float:
        """Return the set-point that makes the limited servo gain what the linear one gains under `value` [m/s].

        `rate` is the speed when it takes effect [m/s].
        """
        step = abs(value - rate)
        if step <= self._acceleration * self._lag:
            return value
        gain = min(step, self.linear_step) * -math.expm1(-self._dt / self._lag) / self._acceleration
        low, high = 0.0, self._dt
        for _ in range(20):
            limited = 0.5 * (low + high)
            reached = limited - self._lag * math.expm1(-(self._dt - limited) / self._lag)
            low, high = (limited, high) if reached < gain else (low, limited)
        return rate + math.copysign(self._acceleration * (self._lag + high), value - rate)


class CommandGovernor:
    """Saturates commands against the predicted state of the winch.

    Parameters
    ----------
    model : the design's augmented model, one input
    winch : its law and lags
    limits : the active ones
    """

    def __init__(self, model: LinearModel, winch: WinchModelParameters, limits: WinchLimits) -> None:
        assert model.dt is not None
        self._winch = winch
        self._dt = model.dt
        self.limits = limits
        self.servo = SpeedServo(winch.time_constant, limits.acceleration, model.dt)
        self._ahead = drum_ahead(model, winch)

    def predict(self, x: Array) -> tuple[float, float]:
        """Return payout [m] and rate [m/s] at the moment the next command takes effect, from the model's state `x`."""
        payout, rate = (self._ahead @ x).tolist()
        return payout, rate

    def govern(
        self,
        wanted: float,
        payout: float,
        rate: float,
        tension: float,
        within: tuple[float, float] | None = None,
    ) -> GovernedCommand:
        """Return the nearest command to `wanted` within the limits.

        Parameters
        ----------
        wanted : rate command [m/s], or payout command [m] of a first-order winch
        payout, rate : of the winch when the command takes effect, with mean motion [m], [m/s]
        tension : expected at the top, for the power limit [N]
        within : least and largest speed of a speed servo, whatever its predicted state [m/s]; None: any
        """
        if self._winch.law == "first_order":
            return self._govern_payout(wanted, payout, tension)
        limits = self.limits
        active: list[str] = []
        speed = limits.speed_under(tension)
        step = self.servo.linear_step
        # limits are those of the speed that the servo is asked for, less what its position loop takes off over the tick
        taken = self._winch.position_gain * (payout + 0.5 * rate * self._dt)
        value = wanted - taken
        bounds = [
            (*self._reach(speed, rate), SPEED if speed >= limits.speed else POWER),
            (*self._room(payout, rate), PAYOUT),
            (rate - step, rate + step, ACCELERATION),
        ]
        if within is not None:
            bounds.append((*within, FADE))
        for lower, upper, name in bounds:
            if value < lower or value > upper:
                active.append(name)
                value = min(max(value, lower), upper)
        reach = self._winch.set_point_reach * limits.speed
        sent = min(max(self.servo.set_point(value, rate), -reach), reach)
        if within is not None:
            more = limits.acceleration * (self._winch.time_constant + self._dt)
            sent = min(max(sent, within[0] - more), within[1] + more)
        return GovernedCommand(value + taken, tuple(active), self._winch.set_point_of(sent) + taken)

    def _reach(self, speed: float, rate: float) -> tuple[float, float]:
        """Return the set-points under which the speed stays within `speed` at the end of the tick, from `rate` [m/s].

        A set-point beyond the speed limit drives a slow servo harder, where the winch takes one.
        """
        reach = self._winch.set_point_reach * speed
        if reach <= speed:
            return -speed, speed
        share = -math.expm1(-self._dt / self._winch.time_constant)
        lower, upper = rate + (-speed - rate) / share, rate + (speed - rate) / share
        return min(max(lower, -reach), speed), max(min(upper, reach), -speed)

    def _room(self, payout: float, rate: float) -> tuple[float, float]:
        """Return the speeds asked for from which the winch can still stop before the ends of its range."""
        limits = self.limits
        lag = self._winch.time_constant
        # the servo needs its lag before it brakes; half the acceleration leaves the other half for errors
        down = limits.payout_maximum - payout - max(rate, 0.0) * 2.0 * lag
        up = payout - limits.payout_minimum - max(-rate, 0.0) * 2.0 * lag
        lower, upper = (math.copysign(approach_speed(abs(room), limits.acceleration, lag), room) for room in (up, down))
        return -lower, upper

    def _govern_payout(self, wanted: float, payout: float, tension: float) -> GovernedCommand:
        limits = self.limits
        step = limits.speed_under(tension) / self._winch.position_rate
        active: list[str] = []
        value = wanted
        for lower, upper, name in (
            (limits.payout_minimum, limits.payout_maximum, PAYOUT),
            (payout - step, payout + step, SPEED),
        ):
            if value < lower or value > upper:
                active.append(name)
                value = min(max(value, lower), upper)
        return GovernedCommand(value, tuple(active), value)


def drum_ahead(model: LinearModel, winch: WinchModelParameters) -> Array:
    """Return rows that give payout and rate of the drum when the command of the tick takes effect, shape (2, n).

    `model` is the augmented one of the `winch`. The moment may be within a tick: up to then the command before acts,
    which is the oldest of the model's chain.
    """
    assert model.dt is not None
    command = model.input_names[0]
    chain = [name for name in model.state_names if name.startswith(command + "_")]
    ticks = winch.command_delay / model.dt
    whole = round(ticks) if abs(ticks - round(ticks)) < 1e-6 else math.floor(ticks)
    ahead = np.linalg.matrix_power(model.A, whole)
    rows = np.array([model.row("payout"), model.row("payout_rate")]) @ ahead
    if whole == len(chain):
        return np.asarray(rows)
    part = _drum_after(winch, (ticks - whole) * model.dt)
    before = ahead[model.state(chain[-1])]
    if winch.law == "first_order":
        payout = part.A[0, 0] * rows[0] + part.B[0, 0] * before
        return np.array([payout, winch.position_rate * (before - payout)])
    return np.asarray(part.A @ rows + part.B @ before[None, :])


@lru_cache(maxsize=8)
def _drum_after(winch: WinchModelParameters, time: float) -> LinearModel:
    """Return the drum of a `winch` over a `time` [s]; every law and the governor of a design ask for the same."""
    return discretise(winch_block(winch), time)


def standing_command(model: LinearModel, winch: WinchModelParameters) -> Array:
    """Return the row that gives the rate command [m/s] under which the drum of a servo `winch` would stand, shape (n,).

    It is what its position loop takes off when the command of the tick takes effect; zero without a position loop. A
    law that asks for a speed adds it. The row is for the states of `model`.
    """
    row: Array = winch.position_gain * drum_ahead(model, winch)[0]
    return row
