"""Parameters of the virtual winch."""

from __future__ import annotations

from dataclasses import dataclass

from heave_node.interface.faults import EncoderFaultParameters, FaultParameters, WinchFaultParameters
from heave_node.parameters import Checked, check_ranges, group, parameter
from heave_node.winch.parameters import WinchFigures, check_position_gain

from cable_sim_node.winch.installed_drives import (
    SERVO,
    DriveGroups,
    absent_drives,
    check_is_installed,
    installed_drives,
)


@dataclass(frozen=True)
class EncoderParameters:
    """The drum encoder: its reading of the payout."""

    resolution: float = parameter(0.001, "m", 0.0, 1.0, "Resolution of the encoder in payout; 0: no quantisation.")
    faults: FaultParameters = group(EncoderFaultParameters)
    backlash: float = parameter(0.0, "m", 0.0, 1.0, "Backlash of the encoder gear; the reading lags by half of it.")

    def __post_init__(self) -> None:
        """Refuse what is out of range, and faults that an encoder cannot have."""
        check_ranges(self)
        self.faults.check("encoder.faults", "encoder")


@dataclass(frozen=True)
class WinchDriftParameters(Checked):
    """What changes slowly while the winch works: a supply that runs down, oil that grows warm.

    Each value goes in a straight line over `duration` from that of the start to a factor of it, and stays there.
    """

    start: float = parameter(0.0, "s", 0.0, None, "Simulated time at which a slow change of the winch begins.")
    duration: float = parameter(0.0, "s", 0.0, 1e5, "Duration of the change; 0: none.")
    gain: float = parameter(1.0, "", 0.1, 3.0, "Factor on speed_gain at the end of the change.")
    speed: float = parameter(1.0, "", 0.05, 2.0, "Factor on speed_limit at the end of the change.")
    acceleration: float = parameter(1.0, "", 0.05, 2.0, "Factor on acceleration_limit at the end of the change.")

    def share(self, time: float) -> float:
        """Return how much of the drift has come about at `time` [s], 0 to 1."""
        return min(max((time - self.start) / self.duration, 0.0), 1.0) if self.duration > 0.0 else 0.0


@dataclass(frozen=True)
class OwnWinchParameters(WinchFigures):
    """The winch without the groups of its drives: how it answers a command, what it cannot exceed, when it stops."""

    drive: str = parameter("speed_servo",
        description="Drive model: an ideal servo (with law), or a detailed drive: electric.*, pump_controlled.* or "
        "valve_controlled.* (heave[drives]).", choices=(SERVO, *installed_drives()),
        also="|".join(absent_drives()), also_words="a drive of heave[drives]")  # fmt: skip
    command_jitter: float = parameter(0.0, "s", 0.0, 10.0,
        "Largest deviation of a command's delay from command_delay, either way, uniform; order is kept.",
    )  # fmt: skip
    stop_deceleration: float = parameter(1.5, "m/s^2", 1e-3, 1e6,
        "Deceleration of a stop (brake request, watchdog, fault); at most acceleration_limit.")  # fmt: skip
    hauling_speed_share: float = parameter(1.0, "", 0.05, 1.0,
        "Speed servo: largest hauling speed as a fraction of speed_limit.")  # fmt: skip
    hauling_acceleration_share: float = parameter(1.0, "", 0.05, 1.0,
        "Speed servo: largest acceleration towards hauling in, as a fraction of acceleration_limit.")  # fmt: skip
    speed_deadband: float = parameter(0.0, "m/s", 0.0, 1.0,
        "Speed servo: dead zone; only the part of a set-point beyond it takes effect.")  # fmt: skip
    drum_radius_error: float = parameter(0.0, "", -0.5, 0.5,
        "Relative error of the drum radius: the cable moves by this much more than drive and encoder "
        "count with the nominal radius.")  # fmt: skip
    rated_pull: float = parameter(0.0, "N", 0.0, None,
        "Rated pull of the winch on its outermost layer, which the largest tension must not exceed; 0: "
        "not stated.")  # fmt: skip
    command_timeout: float = parameter(0.5, "s", 1e-3, 3600.0,
        "Watchdog: simulated time without a fresh command after which the winch stops and brakes.")  # fmt: skip
    supervision_time: float = parameter(1.0, "s", 0.0, 60.0,
        "The drive trips if drum or brake do not follow their commands for this long, or if the drum "
        "moves by 0.05 m from standstill or with the brake on; 0: no supervision.")  # fmt: skip
    encoder: EncoderParameters = group(EncoderParameters)
    drift: WinchDriftParameters = group(WinchDriftParameters)  # speed servo only
    # faults of the command line (`gap`, `delay`), of the drive (`drive`), and the `emergency_stop`
    faults: FaultParameters = group(WinchFaultParameters)

    def __post_init__(self) -> None:
        """Refuse what is out of range, and a set that contradicts itself."""
        check_ranges(self)
        if self.payout_minimum >= self.payout_maximum:
            raise ValueError(
                f"payout_minimum = {self.payout_minimum:g} m must be below payout_maximum = {self.payout_maximum:g} m"
            )
        if not self.payout_minimum <= 0.0 <= self.payout_maximum:
            raise ValueError(
                f"payout 0, where the run starts, must be from payout_minimum = {self.payout_minimum:g} m "
                f"to payout_maximum = {self.payout_maximum:g} m"
            )
        self._check_position_loop()
        check_is_installed(self.drive)
        if self.drive != SERVO and self.law != "speed_servo":
            raise ValueError(f"law = {self.law} is one of drive = speed_servo; drive = {self.drive} follows a speed")
        if self.drift.duration > 0.0 and self.drive != SERVO:
            raise ValueError(f"drift.duration = {self.drift.duration:g} s is one of drive = speed_servo")
        if self.drive != SERVO:
            installed_drives()[self.drive].check(self, getattr(self, self.drive))
        self.faults.check("faults", "winch")

    @property
    def idle_groups(self) -> tuple[str, ...]:
        """Groups of parameters that nothing reads: those of drives that are not chosen."""
        return tuple(name for name in installed_drives() if name != self.drive)

    @property
    def deceleration(self) -> float:
        """Deceleration of a stop [m/s^2]: `stop_deceleration`, as far as the winch is able to."""
        return min(self.stop_deceleration, self.acceleration_limit)

    def _check_position_loop(self) -> None:
        """Refuse a gain with which the drum would swing about its set-point at its limits."""
        slowest = self.acceleration_limit * self.hauling_acceleration_share
        if self.law == "first_order":
            check_position_gain("position_rate", self.position_rate, self.speed_limit, self.acceleration_limit)
        else:
            check_position_gain("position_gain", self.position_gain, self.speed_limit, slowest)


@dataclass(frozen=True)
class WinchParameters(DriveGroups, OwnWinchParameters):
    """The winch: how it answers a command, what it cannot exceed, and when it stops by itself.

    The defaults are the winch of the benchmark scenarios, with an encoder of 1 mm. The parameters of each drive with
    its physics that is installed when this module is imported are a group under its name (`electric`, ...).
    """
