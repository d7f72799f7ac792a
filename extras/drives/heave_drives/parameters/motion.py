"""Parameters that every physical drive has: range, brake, friction at the rope."""

from __future__ import annotations

from dataclasses import dataclass

from heave_node.parameters import Checked, check_ranges, parameter


@dataclass(frozen=True)
class MotionParameters:
    """What the rope's motion is kept within."""

    speed_limit: float = parameter(2.0, "m/s", 1e-3, 100.0, "Largest speed set-point; larger ones are clipped.")
    overspeed: float = parameter(1.1, "", 0.0, 10.0,
        "Overspeed at which the brake trips, as a multiple of speed_limit; 0: no overspeed trip.")  # fmt: skip
    payout_minimum: float = parameter(-50.0, "m", -20_000.0, 20_000.0, "Lower end of the payout range.")
    payout_maximum: float = parameter(50.0, "m", -20_000.0, 20_000.0, "Upper end of the payout range.")
    stop_deceleration: float = parameter(1.5, "m/s^2", 1e-3, 1e6,
        "Deceleration under the brake and ahead of an end stop.")  # fmt: skip
    position_gain: float = parameter(0.0, "1/s", 0.0, 100.0,
        "Gain from payout error to speed; 0 follows the rate set-point alone.")  # fmt: skip

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

    coulomb: float = parameter(0.0, "N", 0.0, 1e9, "Friction independent of load.")
    load: float = parameter(0.0, "", 0.0, 1.0, "Friction proportional to tension, as a fraction of it.")
    slip_speed: float = 0.01  # rope speed at which the two frictions above reach 76 % of their value [m/s]
    viscous: float = parameter(0.0, "N s/m", 0.0, 1e9, "Friction proportional to speed.")

    def rate(self, tension: float, mass: float) -> float:
        """Return how fast friction alone would stop `mass` [kg] near rest under `tension` [N], as 1/time [1/s]."""
        return ((self.coulomb + self.load * tension) / self.slip_speed + self.viscous) / mass
