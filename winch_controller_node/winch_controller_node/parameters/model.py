"""The assumed plant, winch and sea; for the sensors see `interface.sensors`.

Names are those of the plant's own parameters where both have one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from heave_node.crane.kinematics import JOINTS, CraneParameters
from heave_node.parameters import ParameterError, parameter
from heave_node.winch.parameters import WinchFigures, check_position_gain
from wave_vessel_node.parameters import FILTER_CHOICES, SeaParameters, VesselAnswer


@dataclass(frozen=True)
class CableModelParameters:
    """The two-state cable a x'' + b x' + x = x0 - payout (thesis Eq. 6.2): from the plant's data, or as identified."""

    inertia: float = parameter(0.0, "s^2", 0.0, 1e4,
        "a of a x'' + b x' + x = x0 - payout; 0 derives it from cable, unit, length.")  # fmt: skip
    damping: float = parameter(0.0, "s", 0.0, 1e4,
        "b of a x'' + b x' + x = x0 - payout; 0: from drag, linearised at 0.1 m, or at the load's speed "
        "if that gives more. A stated value holds at any speed.")  # fmt: skip
    inertia_factor: float = parameter(1.0, "", 0.1, 10.0, "Factor on a, for model errors and trials.")
    damping_factor: float = parameter(1.0, "", 0.0, 100.0, "Factor on b, for model errors and trials.")
    # amplitude at which drag is linearised; small, because the compensated unit hardly moves [m]
    drag_amplitude: float = 0.1
    disturbance: float = parameter(3e-4, "m/s^2/sqrt(Hz)", 0.0, 10.0,
        "Unmodelled white acceleration of the unit (two-sided density).")  # fmt: skip


@dataclass(frozen=True)
class WinchModelParameters(WinchFigures):
    """The winch as the controller assumes it: law, lags, delay and limits."""

    hauling_gain: float = parameter(1.0, "", 0.1, 10.0, "Factor on speed_gain while hauling in.")
    set_point_reach: float = parameter(1.0, "", 1.0, 1e3,
        "Largest effective speed set-point, as a multiple of speed_limit; above 1 it drives a slow servo harder.",
    )  # fmt: skip
    disturbance: float = parameter(0.01, "m/s^2/sqrt(Hz)", 0.0, 10.0,
        "Unmodelled white acceleration of the drum (two-sided density).")  # fmt: skip

    def gain_at(self, speed: float) -> float:
        """Return the speed of the drum over its set-point, at a `speed` [m/s]."""
        return self.speed_gain if speed >= self.creep else self.speed_gain * self.hauling_gain

    def set_point_of(self, speed: float) -> float:
        """Return the set-point of which the servo makes a `speed` [m/s]."""
        return (speed - self.creep) / self.gain_at(speed)

    def speed_of(self, set_point: float) -> float:
        """Return the speed that the servo makes of a `set_point` [m/s]."""
        gain = self.speed_gain if set_point >= 0.0 else self.speed_gain * self.hauling_gain
        return gain * set_point + self.creep

    def with_limits_of(self, other: WinchModelParameters) -> WinchModelParameters:
        """Return it with the limits and gains of an `other` winch: what the linear model of a winch does not hold."""
        return replace(
            self,
            speed_gain=other.speed_gain,
            hauling_gain=other.hauling_gain,
            creep=other.creep,
            speed_limit=other.speed_limit,
            acceleration_limit=other.acceleration_limit,
            power_limit=other.power_limit,
        )

    def __post_init__(self) -> None:
        if self.payout_minimum >= self.payout_maximum:
            raise ParameterError(
                f"winch.payout_minimum = {self.payout_minimum:g} m must be below winch.payout_maximum = "
                f"{self.payout_maximum:g} m"
            )
        if self.law == "speed_servo":
            check_position_gain("winch.position_gain", self.position_gain, self.speed_limit, self.acceleration_limit)


@dataclass(frozen=True)
class SeaModelParameters(SeaParameters):
    """The sea the controller is designed for."""

    significant_wave_height: float = parameter(1.0, "m", 0.01, 25.0,
        "Significant wave height (of the wind sea in ochi_hubble).")  # fmt: skip
    filter_form: str = parameter("auto",
        description="Shaping filter that models the sea; auto: the best fit.",
        choices=FILTER_CHOICES)  # fmt: skip
    filter_states: int = parameter(6, "", 4, 16, "States of a fitted filter; even. Two-peaked seas need 10.")
    direction: float = parameter(math.pi, "rad", -6.3, 6.3,
        "Direction the waves travel to, from world x, anticlockwise; vessels with RAOs.")  # fmt: skip

    @property
    def follows_spectrum(self) -> bool:
        """Tell whether another height or period gives another filter: that of the thesis is a sea of its own."""
        return self.filter_form != "thesis"


@dataclass(frozen=True)
class VesselModelParameters(VesselAnswer):
    """The vessel as the controller assumes it: of second order (thesis Eq. 6.25), also where fitted to RAOs."""

    accept_implausible: bool = parameter(False, description="Take implausible RAOs of rao_file as they are.")
    heading: float = parameter(0.0, "rad", -6.3, 6.3,
        "Heading of the vessel from world x, anticlockwise; models rao, fitted.")  # fmt: skip
    speed: float = parameter(0.0, "m/s", 0.0, 15.0, "Forward speed; models rao, fitted.")


@dataclass(frozen=True)
class WeightParameters:
    """Sizes of equal weight in the quadratic cost (Bryson's rule): a smaller size is a larger weight.

    0 leaves it out.
    """

    unit_heave: float = parameter(0.05, "m", 0.0, None,
        "Cost of laws lqr and lqg: scale of unit heave (one scale of each costs the same); smaller is tighter, 0 "
        "removes it. Law mpc has mpc.unit_heave.")  # fmt: skip
    unit_heave_rate: float = 0.0  # the same cost: scale of the unit's heave rate; 0 leaves it out [m/s]
    outlet_heave: float = parameter(0.05, "m", 0.0, None,
        "Cost of laws lqr and lqg: scale of boom-tip heave less payout; 0 removes it.")  # fmt: skip
    payout: float = parameter(50.0, "m", 0.0, None,
        "Cost of laws lqr and lqg: scale of payout about its mean, which prevents drift; 0 removes it.")  # fmt: skip
    payout_rate: float = 0.0  # the same cost: scale of payout speed; 0 leaves it out [m/s]
    payout_acceleration: float = parameter(2.0, "m/s^2", 0.0, None,
        "Cost of laws lqr and lqg: scale of payout acceleration; 0 removes it.")  # fmt: skip
    command: float = parameter(20.0, "m/s", 0.0, None,
        "Cost of laws lqr and lqg: scale of the command (m for a first-order winch); must not be 0.")  # fmt: skip


@dataclass(frozen=True)
class EstimatorParameters:
    """The Kalman filter."""

    gate: float = parameter(25.0, "", 1.0, 1e6, "Normalised innovation squared above which a reading is rejected.")
    # rejected readings in a row after which the sensor's next is accepted, with enlarged covariance
    gate_limit: int = 100
    largest_age: float = parameter(1.0, "s", 0.0, 10.0, "Readings older than this on arrival are discarded.")


CONFIRMED_AFTER = 5.0
"""A pose elsewhere is used once it has gone on without a further jump for so long [s]."""


@dataclass(frozen=True)
class CraneModelParameters(CraneParameters):
    """Lengths and reference pose of the crane, and what of its pose is read on `crane/pose`."""

    joints: tuple[str, ...] = parameter(JOINTS,
        description="Joints in crane/pose; others keep the reference pose.", choices=JOINTS)  # fmt: skip
    pose_timeout: float = 1.0  # age above which the newest usable pose is stale; the last one is then held [s]
    # fastest that slew, luff or knuckle can turn: an angle that changes faster has jumped [rad/s]
    largest_turn_rate: float = 0.1
    # fastest that the boom can extend: an extension that changes faster has jumped [m/s]
    largest_extension_rate: float = 0.5

    @property
    def largest_rates(self) -> tuple[float, ...]:
        """Fastest that each joint can move [rad/s], [m/s]."""
        turn = self.largest_turn_rate
        return turn, turn, turn, self.largest_extension_rate
