"""Parameters of the motion reference unit with its faults, and of what it makes of the sea state."""

from __future__ import annotations

from dataclasses import dataclass

from heave_node.interface.faults import FaultParameters, MruFaultParameters
from heave_node.parameters import group, parameter


@dataclass(frozen=True)
class MruParameters:
    """The motion reference unit at the boom tip."""

    rate: float = parameter(
        0.0, unit="Hz", minimum=0.0, maximum=1000.0, description="Rate of readings; 0 means one per tick."
    )
    noise: float = parameter(
        0.01,
        unit="m",
        minimum=0.0,
        maximum=1.0,
        description="White noise of heave: standard deviation of each reading.",
    )
    rate_noise: float = parameter(
        0.01,
        unit="m/s",
        minimum=0.0,
        maximum=1.0,
        description="White noise of heave rate: standard deviation of each reading.",
    )
    measures_rate: bool = parameter(
        True, unit="", description="It measures heave rate and acceleration; many units state heave alone (NaN then)."
    )
    wander: float = parameter(
        0.0,
        unit="m",
        minimum=0.0,
        maximum=10.0,
        description="Error of heave that is not white, a first-order Gauss-Markov process: standard deviation.",
    )
    wander_time: float = parameter(
        60.0,
        unit="s",
        minimum=0.01,
        maximum=1e4,
        description="Time constant of wander: a second colours the noise, a minute lets the zero drift.",
    )
    resolution: float = parameter(
        0.0, unit="m", minimum=0.0, maximum=1.0, description="Step of the readings of heave; 0 means none."
    )
    rate_resolution: float = parameter(
        0.0, unit="m/s", minimum=0.0, maximum=1.0, description="Step of the readings of heave rate; 0 means none."
    )
    high_pass_period: float = parameter(
        0.0,
        unit="s",
        minimum=0.0,
        maximum=300.0,
        description="Cut-off period of the second-order high-pass filter; 0 means no filter.",
    )
    high_pass_damping: float = parameter(
        0.7071, unit="", minimum=0.2, maximum=2.0, description="Damping ratio of the high-pass filter."
    )
    scale_error: float = parameter(
        0.0, unit="", minimum=-0.5, maximum=0.5, description="Relative scale error: 0.05 reads 5 % high."
    )
    lever_arm_error: tuple[float, ...] = parameter(
        (0.0, 0.0, 0.0),
        unit="m",
        minimum=-10.0,
        maximum=10.0,
        length=3,
        description="Error of the lever arm entered in the unit, vessel axes; it couples pitch and roll into heave.",
    )
    latency: float = parameter(
        0.0, unit="s", minimum=0.0, maximum=5.0, description="Delay of a reading, which its stamp accounts for."
    )
    stamp_error: float = parameter(
        0.0,
        unit="s",
        minimum=-5.0,
        maximum=5.0,
        description="Time by which the stamp is late: above 0 an additional delay that it does not account for, below "
        "0 readings are newer than their stamp.",
    )
    settling_periods: float = parameter(
        10.0,
        unit="",
        minimum=0.0,
        maximum=50.0,
        description="After a restart or a turn the status is settling for this many periods of the high-pass filter.",
    )
    restart_bias: float = parameter(
        0.02,
        unit="m/s^2",
        minimum=-1.0,
        maximum=1.0,
        description="Error of vertical acceleration right after a restart; it decays with the period of the high-pass "
        "filter.",
    )
    turn_sensitivity: float = parameter(
        0.01,
        unit="",
        minimum=-1.0,
        maximum=1.0,
        description="Error of vertical acceleration per centripetal acceleration in a turn (tilt of the vertical).",
    )
    restart_duration: float = parameter(
        2.0, unit="s", minimum=0.0, maximum=600.0, description="Time for which the unit is silent while it restarts."
    )
    faults: FaultParameters = group(MruFaultParameters)

    def __post_init__(self) -> None:
        """Refuse faults that the unit cannot have."""
        self.faults.check("mru.faults", "mru")


@dataclass(frozen=True)
class SeaStateEstimateParameters:
    """The running estimate of the sea state from the MRU record."""

    window: float = parameter(
        1800.0,
        unit="s",
        minimum=120.0,
        maximum=21600.0,
        description="Length of the record on which the estimate is based.",
    )
    segment: float = parameter(
        200.0, unit="s", minimum=30.0, maximum=3600.0, description="Length of one Welch segment (half overlapping)."
    )
    period: float = parameter(30.0, unit="s", minimum=1.0, maximum=3600.0, description="Interval between estimates.")

    def __post_init__(self) -> None:
        if self.window < 2 * self.segment:
            raise ValueError(
                f"estimate.window ({self.window:g} s) must hold at least two of estimate.segment ({self.segment:g} s)"
            )
