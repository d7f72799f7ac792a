"""What an entrant knows beforehand, what it measures and what it commands: plain data, no ROS.

An entrant is a class. It is created for each run with the facts of the case, and asked once per sample time:

    class MyController:
        def __init__(self, facts: Facts) -> None: ...
        def step(self, measurement: Measurement) -> Command: ...

Signs: heave is positive up, depth positive down, payout positive lets rope out and lowers the unit; SI units, radians.
A unit on a stiff rope is held still by payout = boom-tip heave.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Protocol

MRU_OK, MRU_SETTLING, MRU_INVALID = 0, 1, 2
"""Status words of an MRU reading."""

WINCH_OK = 0
"""Fault of a winch that has none; any other number stopped it by itself."""


@dataclass(frozen=True)
class MruReading:
    """The motion reference unit's word on the boom tip.

    Attributes
    ----------
    time : of the measurement, as stamped [s]
    heave, heave_rate, heave_acceleration : about the mean, positive up [m], [m/s], [m/s^2]; the acceleration is NaN
        where the unit does not tell it
    roll, pitch : of the vessel [rad]
    status : MRU_OK, MRU_SETTLING or MRU_INVALID
    sequence : counts readings; a gap is a lost one
    heave_sigma, heave_rate_sigma : accuracy that the unit states, one standard deviation [m], [m/s]; NaN where it
        states none
    """

    time: float
    heave: float
    heave_rate: float
    heave_acceleration: float
    roll: float = 0.0
    pitch: float = 0.0
    status: int = MRU_OK
    sequence: int = 0
    heave_sigma: float = float("nan")
    heave_rate_sigma: float = float("nan")


@dataclass(frozen=True)
class Reading:
    """One scalar: time of the measurement [s] and value."""

    time: float
    value: float


@dataclass(frozen=True)
class WinchReading:
    """What the winch reports at the time of the measurement.

    Attributes
    ----------
    payout, payout_rate : of the encoder [m], [m/s]
    brake : the brake holds the drum; it releases with the first command that does not request it
    fault : WINCH_OK, or why the winch stopped by itself; it clears when the brake is requested, and then no longer
    limits : limits that acted since the last measurement, as in heave_msgs/WinchState
    command : number of the newest command that has taken effect; the first of a run is 1, 0 is none yet
    instruments : what the drive measures inside, by name with unit; empty where the case gives none
    """

    payout: float
    payout_rate: float
    brake: bool = False
    fault: int = WINCH_OK
    limits: int = 0
    command: int = 0
    instruments: Mapping[str, float] = field(default_factory=dict)


NO_WINCH_READING = WinchReading(payout=0.0, payout_rate=0.0, brake=True)
"""The winch in the first measurement of a run, before it has reported anything."""


@dataclass(frozen=True)
class Target:
    """Where the operator wants the unit. Compensation works about it.

    Attributes
    ----------
    payout, payout_rate : mean payout [m] and its rate [m/s], positive lowers
    """

    payout: float = 0.0
    payout_rate: float = 0.0


@dataclass(frozen=True)
class Measurement:
    """All that is delivered at one sample time.

    Readings come at their own rates, late by their latency, with noise and faults: often none, sometimes several.

    Attributes
    ----------
    time : now [s]
    mru : of the motion reference unit
    depth : of the unit, positive down [m], from its pressure sensor
    load_cell : top tension [N]
    winch : the winch now
    target : what the operator wants now
    """

    time: float
    mru: tuple[MruReading, ...]
    depth: tuple[Reading, ...]
    load_cell: tuple[Reading, ...]
    winch: WinchReading
    target: Target


@dataclass(frozen=True)
class Command:
    """What the winch shall do until the next command.

    Attributes
    ----------
    payout_rate : set-point [m/s], positive pays out
    payout : set-point [m]; it has an effect only where the winch has a position gain (`WinchFacts.position_gain`)
    brake : is to be on
    """

    payout_rate: float = 0.0
    payout: float = 0.0
    brake: bool = False


@dataclass(frozen=True)
class WinchFacts:
    """The winch as its maker states it; the true one may differ (case b9).

    Attributes
    ----------
    time_constant : lag of the speed behind its set-point [s]
    command_delay : from the start of a sample time to the command's effect [s]
    speed_limit, acceleration_limit : [m/s], [m/s^2]; acceleration may be unlimited (infinite)
    set_point_limit : largest speed set-point that has an effect [m/s]; above speed_limit it drives a lag harder
    payout_minimum, payout_maximum : range [m]
    position_gain : of the winch's own position loop, speed per payout error [1/s]
    """

    time_constant: float
    command_delay: float
    speed_limit: float
    set_point_limit: float
    acceleration_limit: float
    payout_minimum: float
    payout_maximum: float
    position_gain: float = 0.0


@dataclass(frozen=True)
class SensorFacts:
    """The sensors by their data sheets, standard deviations of white noise; 0 is a perfect one.

    Attributes
    ----------
    mru_noise, mru_rate_noise, mru_acceleration_noise : [m], [m/s], [m/s^2]
    mru_high_pass_period : cut-off of the unit's high-pass [s]; 0 is none
    depth_noise, depth_latency : [m], [s]
    encoder_step : [m]
    load_cell_noise : [N]; in cases of scenarios it is not stated here, half a percent of the static tension as shipped
    """

    mru_noise: float
    mru_rate_noise: float
    mru_acceleration_noise: float
    mru_high_pass_period: float
    depth_noise: float
    depth_latency: float
    encoder_step: float
    load_cell_noise: float = 0.0


@dataclass(frozen=True)
class SeaFacts:
    """The sea that is expected.

    Attributes
    ----------
    significant_wave_height : [m]
    peak_period : [s]
    """

    significant_wave_height: float
    peak_period: float


@dataclass(frozen=True)
class Facts:
    """What is known of a case beforehand.

    Attributes
    ----------
    case : name
    sample_time : between two measurements [s]
    duration : of the run [s]
    winch, sensors, sea : see there
    belief : everything else that a designer would know (cable, unit, vessel, programme of depth), by the parameter
        names of this suite's controller (winch_controller_node/README.md)
    preview : the boom tip's true future: heave and its first four derivatives at a time [s]. Only entrants that say
        `needs_preview = True` get it; they are references, not entries. None for all others
    """

    case: str
    sample_time: float
    duration: float
    winch: WinchFacts
    sensors: SensorFacts
    sea: SeaFacts
    belief: Mapping[str, object]
    preview: Callable[[float], tuple[float, float, float, float, float]] | None = None


class Controller(Protocol):
    """An entrant, made for one run."""

    def step(self, measurement: Measurement) -> Command:
        """Return the command until the next sample time, given the `measurement` of this one."""
        ...


Entrant = Callable[[Facts], Controller]
"""A class or function that makes a controller of the facts."""
