"""Parameters that every physical drive has: range, brake, friction at the rope."""

from __future__ import annotations

from dataclasses import dataclass

from heave_node.parameters import Checked, check_ranges, parameter


@dataclass(frozen=True)
class MotionParameters:
    """What the rope's motion is kept within."""

    speed_limit: float = parameter(
        2.0, unit="m/s", minimum=1e-3, maximum=100.0, description="Largest speed set-point; larger ones are clipped."
    )
    overspeed: float = parameter(
        1.1,
        unit="",
        minimum=0.0,
        maximum=10.0,
        description="Overspeed at which the brake trips, as a multiple of speed_limit; 0: no overspeed trip.",
    )
    payout_minimum: float = parameter(
        -50.0, unit="m", minimum=-20_000.0, maximum=20_000.0, description="Lower end of the payout range."
    )
    payout_maximum: float = parameter(
        50.0, unit="m", minimum=-20_000.0, maximum=20_000.0, description="Upper end of the payout range."
    )
    stop_deceleration: float = parameter(
        1.5,
        unit="m/s^2",
        minimum=1e-3,
        maximum=1e6,
        description="Deceleration under the brake and ahead of an end stop.",
    )
    position_gain: float = parameter(
        0.0,
        unit="1/s",
        minimum=0.0,
        maximum=100.0,
        description="Gain from payout error to speed; 0 follows the rate set-point alone.",
    )

    def __post_init__(self) -> None:
        check_ranges(self)
        if not self.payout_minimum <= 0.0 <= self.payout_maximum or self.payout_minimum == self.payout_maximum:
            raise ValueError(
                f"payout 0, where the drive starts, must be from payout_minimum = {self.payout_minimum:g} m to "
                f"payout_maximum = {self.payout_maximum:g} m, and these must differ"
            )
        if 0.0 < self.overspeed < 1.0:
            raise ValueError(f"overspeed = {self.overspeed:g} must be 0 or at least 1: it is above speed_limit")


@dataclass(frozen=True)
class FrictionParameters(Checked):
    """Friction of bearings, gear and sheaves, as a force at the rope, against the motion."""

    coulomb: float = parameter(0.0, unit="N", minimum=0.0, maximum=1e9, description="Friction independent of load.")
    load: float = parameter(
        0.0, unit="", minimum=0.0, maximum=1.0, description="Friction proportional to tension, as a fraction of it."
    )
    slip_speed: float = parameter(
        0.01,
        unit="m/s",
        minimum=1e-6,
        maximum=100.0,
        description="Rope speed at which the two frictions above reach 76 % of their value.",
    )
    viscous: float = parameter(
        0.0, unit="N s/m", minimum=0.0, maximum=1e9, description="Friction proportional to speed."
    )

    def rate(self, tension: float, mass: float) -> float:
        """Return how fast friction alone would stop `mass` [kg] near rest under `tension` [N], as 1/time [1/s]."""
        return ((self.coulomb + self.load * tension) / self.slip_speed + self.viscous) / mass
