"""The parts of the loop as continuous linear models: cable and unit, winch, outlet, MRU, slow states.

Signs: heave positive up, payout positive lowers the unit: a x'' + b x' + x = x0 - payout, thesis Eq. 6.4 with
u = -payout.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from heave_node.numerics.linear_model import LinearModel, ModelError, linear_model

from winch_controller_node.interface.sensors import MruModelParameters
from winch_controller_node.parameters.model import WinchModelParameters

RATE_COMMAND = "payout_rate_command"
PAYOUT_COMMAND = "payout_command"


@dataclass(frozen=True)
class CableModel:
    """a x'' + b x' + x = x0 - payout (thesis Eq. 6.2)."""

    a: float  # [s^2]
    b: float  # [s]
    stiffness: float = 1.0  # top tension per metre of boom tip over outlet and unit [N/m]
    static_tension: float = 0.0  # mean tension at the top [N]
    unit_weight: float = math.inf  # of the unit less buoyancy, that at the lower end [N]
    # quadratic drag: at a speed v of the unit the damping is drag |v|, where that is more than b [s^2/m]
    drag: float = 0.0
    # a by which the unit swings over a, which fits the waves: the cable has mass of its own [-]
    natural_ratio: float = 1.0
    participation: float = 1.0  # of that swing in a motion of the outlet, see `first_mode` [-]

    def __post_init__(self) -> None:
        if not (self.a > 0.0 and self.b >= 0.0):
            raise ModelError(f"a cable model needs a > 0 and b >= 0; got a = {self.a:g} s^2, b = {self.b:g} s")

    @property
    def natural_a(self) -> float:
        """A by which the unit swings [s^2]: one over the square of its natural frequency."""
        return self.natural_ratio * self.a


def cable_block(cable: CableModel, disturbance: float = 0.0) -> LinearModel:
    """Return the cable and unit: inputs boom_tip_heave and payout, thesis Eq. 6.6, outputs of the unit and the tension.

    `disturbance` is the density of a white acceleration of the unit [m/s^2/sqrt(Hz)], two-sided.
    """
    a, b, k = cable.a, cable.b, cable.stiffness
    return linear_model(
        [[0.0, 1.0], [-1.0 / a, -b / a]],
        states=("unit_heave", "unit_heave_rate"),
        inputs={"boom_tip_heave": [0.0, 1.0 / a], "payout": [0.0, -1.0 / a]},
        outputs={
            "unit_heave": [1.0, 0.0],
            "unit_heave_rate": [0.0, 1.0],
            "unit_heave_acceleration": [-1.0 / a, -b / a],
            "tension": [-k, 0.0],
        },
        feedthrough={
            ("unit_heave_acceleration", "boom_tip_heave"): 1.0 / a,
            ("unit_heave_acceleration", "payout"): -1.0 / a,
            ("tension", "boom_tip_heave"): k,
            ("tension", "payout"): -k,
        },
        noises={"unit_disturbance": [0.0, disturbance]},
    )


def winch_block(winch: WinchModelParameters) -> LinearModel:
    """Return the winch: first order (thesis Eq. 6.1, input payout_command) or speed servo (input payout_rate_command).

    The servo's payout set-point is the mean payout, about which `payout` counts: v' = (v_set - k_p payout - v)/T.
    """
    if winch.law == "first_order":
        K = winch.position_rate
        return linear_model(
            [[-K]],
            states=("payout",),
            inputs={PAYOUT_COMMAND: [K]},
            outputs={"payout": [1.0], "payout_rate": [-K]},
            feedthrough={("payout_rate", PAYOUT_COMMAND): K},
            noises={"winch_disturbance": [winch.disturbance]},
        )
    T = winch.time_constant
    return linear_model(
        [[0.0, 1.0], [-winch.position_gain / T, -1.0 / T]],
        states=("payout", "payout_rate"),
        inputs={RATE_COMMAND: [0.0, 1.0 / T]},
        outputs={
            "payout": [1.0, 0.0],
            "payout_rate": [0.0, 1.0],
            "payout_acceleration": [-winch.position_gain / T, -1.0 / T],
        },
        feedthrough={("payout_acceleration", RATE_COMMAND): 1.0 / T},
        noises={"winch_disturbance": [0.0, winch.disturbance]},
    )


def command_name(winch: WinchModelParameters) -> str:
    """Return the name of the command input: payout_rate_command, or payout_command for a first-order winch."""
    return PAYOUT_COMMAND if winch.law == "first_order" else RATE_COMMAND


def outlet_block() -> LinearModel:
    """Return the outlet: boom-tip heave less payout, what is left of the heave where the cable leaves the vessel."""
    return linear_model(
        np.zeros((0, 0)),
        states=(),
        inputs={"boom_tip_heave": [], "payout": []},
        outputs={"outlet_heave": []},
        feedthrough={("outlet_heave", "boom_tip_heave"): 1.0, ("outlet_heave", "payout"): -1.0},
    )


def mru_block(mru: MruModelParameters) -> LinearModel:
    """Return what a motion reference unit `mru` makes of the boom tip: its high-pass as two states, or none.

    reading = truth - e, e'' + 2 zeta w e' + w^2 e = 2 zeta w x0' + w^2 x0: the second-order high-pass, exactly.
    """
    inputs = ("boom_tip_heave", "boom_tip_heave_rate")
    through = {("mru_heave", inputs[0]): 1.0, ("mru_heave_rate", inputs[1]): 1.0}
    if mru.high_pass_period == 0.0:
        return linear_model(
            np.zeros((0, 0)),
            states=(),
            inputs={name: [] for name in inputs},
            outputs={"mru_heave": [], "mru_heave_rate": []},
            feedthrough=through,
        )
    cut_off = 2.0 * math.pi / mru.high_pass_period
    damping = 2.0 * mru.high_pass_damping * cut_off
    return linear_model(
        [[0.0, 1.0], [-(cut_off**2), -damping]],
        states=("mru_offset", "mru_offset_rate"),
        inputs={inputs[0]: [0.0, cut_off**2], inputs[1]: [0.0, damping]},
        outputs={"mru_heave": [-1.0, 0.0], "mru_heave_rate": [0.0, -1.0]},
        feedthrough=through,
    )


def slow_block(name: str, drift: float) -> LinearModel:
    """Return the slow state `name`: a random walk of `drift` [unit/sqrt(s)] (depth bias, scale error)."""
    return linear_model([[0.0]], states=(name,), outputs={name: [1.0]}, noises={f"{name}_drift": [drift]})
