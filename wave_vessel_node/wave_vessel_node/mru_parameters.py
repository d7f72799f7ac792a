"""Parameters of the motion reference unit with its faults, and of what it makes of the sea state."""

from __future__ import annotations

from dataclasses import dataclass

from heave_node.interface.faults import FaultParameters, MruFaultParameters
from heave_node.parameters import group, parameter


@dataclass(frozen=True)
class MruParameters:
    """The motion reference unit at the boom tip."""

    rate: float = parameter(0.0, "Hz", 0.0, 1000.0, "Rate of readings; 0 means one per tick.")
    noise: float = parameter(0.01, "m", 0.0, 1.0, "White noise of heave: standard deviation of each reading.")
    rate_noise: float = parameter(0.01, "m/s", 0.0, 1.0,
        "White noise of heave rate: standard deviation of each reading.")  # fmt: skip
    measures_rate: bool = parameter(True,
        description="It measures heave rate and acceleration; many units state heave alone (NaN then).")  # fmt: skip
    wander: float = parameter(0.0, "m", 0.0, 10.0,
        "Error of heave that is not white, a first-order Gauss-Markov process: standard deviation.")  # fmt: skip
    wander_time: float = parameter(60.0, "s", 0.01, 1e4,
        "Time constant of wander: a second colours the noise, a minute lets the zero drift.")  # fmt: skip
    resolution: float = parameter(0.0, "m", 0.0, 1.0, "Step of the readings of heave; 0 means none.")
    rate_resolution: float = parameter(0.0, "m/s", 0.0, 1.0, "Step of the readings of heave rate; 0 means none.")
    high_pass_period: float = parameter(0.0, "s", 0.0, 300.0,
        "Cut-off period of the second-order high-pass filter; 0 means no filter.")  # fmt: skip
    high_pass_damping: float = parameter(0.7071, "", 0.2, 2.0, "Damping ratio of the high-pass filter.")
    scale_error: float = parameter(0.0, "", -0.5, 0.5, "Relative scale error: 0.05 reads 5 % high.")
    lever_arm_error: tuple[float, ...] = parameter((0.0, 0.0, 0.0), "m", -10.0, 10.0,
        "Error of the lever arm entered in the unit, vessel axes; it couples pitch and roll into heave.",
        length=3)  # fmt: skip
    latency: float = parameter(0.0, "s", 0.0, 5.0, "Delay of a reading, which its stamp accounts for.")
    stamp_error: float = parameter(0.0, "s", -5.0, 5.0,
        "Time by which the stamp is late: above 0 an additional delay that it does not account for, below 0 readings "
        "are newer than their stamp.")  # fmt: skip
    # after a restart or a turn the status is settling for this many periods of the high-pass filter [-]
    settling_periods: float = 10.0
    # error of vertical acceleration right after a restart [m/s^2]; it decays with the period of the high-pass filter
    restart_bias: float = 0.02
    # error of vertical acceleration per centripetal acceleration in a turn (tilt of the vertical) [-]
    turn_sensitivity: float = 0.01
    restart_duration: float = 2.0  # time for which the unit is silent while it restarts [s]
    faults: FaultParameters = group(MruFaultParameters)

    def __post_init__(self) -> None:
        """Refuse faults that the unit cannot have."""
        self.faults.check("mru.faults", "mru")


@dataclass(frozen=True)
class SeaStateEstimateParameters:
    """The running estimate of the sea state from the MRU record."""

    window: float = parameter(1800.0, "s", 120.0, 21600.0, "Length of the record on which the estimate is based.")
    segment: float = parameter(200.0, "s", 30.0, 3600.0, "Length of one Welch segment (half overlapping).")
    period: float = parameter(30.0, "s", 1.0, 3600.0, "Interval between estimates.")

    def __post_init__(self) -> None:
        if self.window < 2 * self.segment:
            raise ValueError(
                f"estimate.window ({self.window:g} s) must hold at least two of estimate.segment ({self.segment:g} s)"
            )
