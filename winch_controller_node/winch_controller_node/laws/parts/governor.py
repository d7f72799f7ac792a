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
from heave_core.law_table import Shaped
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel
from heave_node.numerics.linear_sampling import discretise

from winch_controller_node.model.blocks import winch_block
from winch_controller_node.parameters.model import WinchModelParameters

SPEED, ACCELERATION, PAYOUT, POWER, TENSION, FADE = "speed", "acceleration", "payout", "power", "tension", "fade_out"


class GovernedCommand(NamedTuple):
    """What came out."""

    value: float  # command in the terms of the linear model, in its unit: the estimator's input
    active: tuple[str, ...]  # names of the limits that shaped it
    # the same for the winch, in its unit: its acceleration limiter acts within the tick, and it has a gain of its own
    sent: float


SHAPED_NAMES = {
    Shaped.BY_SPEED: SPEED,
    Shaped.BY_POWER: POWER,
    Shaped.BY_RANGE: PAYOUT,
    Shaped.BY_ACCELERATION: ACCELERATION,
    Shaped.BY_FADING: FADE,
}
"""Names of what shapes the command of a servo, in the order in which it does."""


@lru_cache
def shaped_by(bits: int, *, is_first_order: bool) -> tuple[str, ...]:
    """Return the names of what shaped a command by `bits` of the core, in the order in which it did.

    With `is_first_order` the command is a payout, which its range bounds first.
    """
    names = tuple(name for bit, name in SHAPED_NAMES.items() if bits & bit)
    return names[::-1] if is_first_order else names


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
