"""What the controller is given and gives in one tick: plain data, no ROS."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from heave_node.interface.alarm import Alarm
from heave_node.interface.codes import SensorLevel
from heave_node.interface.preview import HeavePreview
from heave_node.interface.sensors import MruReading

from winch_controller_node.interface.observations import Observations


class ScalarReading(NamedTuple):
    """One scalar: time of measurement [s] and value in the sensor's unit."""

    time: float
    value: float


class WinchReading(NamedTuple):
    """The winch's own report, as in heave_msgs/WinchState."""

    time: float  # of the state [s]
    encoder_payout: float  # as the encoder reads it [m]
    encoder_payout_rate: float  # as the encoder reads it [m/s]
    brake: bool  # it is on
    fault: int = 0  # number of heave_node.interface.codes.WinchFault; hardware may have others
    command_sequence: int = 0  # of the newest command taken
    limits_hit: int = 0  # heave_node.interface.codes.WinchLimit that acted in the last interval


@dataclass(frozen=True, slots=True)
class Lateness:
    """What held the ticks of the last seconds up, in wall time; nothing in lockstep."""

    of_clock: float = 0.0  # ticks began so much late: the whole machine stalled, or the clock master [s]
    of_controller: float = 0.0  # the controller entered them so much later than they began [s]


ON_TIME = Lateness()
"""Lateness where no tick was late."""


@dataclass(frozen=True)
class Measurements:
    """All that was delivered at a tick."""

    mru: tuple[MruReading, ...] = ()  # readings of the motion reference unit
    # of the other sensors, by name: `depth` of the unit, positive down [m]; `velocity`, vertical, positive up [m/s];
    # `imu`, its vertical acceleration without gravity [m/s^2]; `load_cell`, the top tension [N]
    scalar: Mapping[str, tuple[ScalarReading, ...]] = field(default_factory=dict)
    winch: WinchReading | None = None  # newest state of the winch; None: none came
    preview: HeavePreview | None = None  # newest one of the boom tip; None: none came
    lateness: Lateness = ON_TIME  # of the ticks, so that a command timeout is reported with its cause

    def of(self, sensor: str) -> tuple[ScalarReading, ...]:
        """Return the readings of a sensor; none where none came."""
        return self.scalar.get(sensor, ())


class WinchOrder(NamedTuple):
    """The command of a tick."""

    sequence: int  # number of the command
    payout: float  # set-point [m]
    payout_rate: float  # set-point [m/s]
    brake: bool  # True: on
    mean_payout: float = math.nan  # that the winch works about [m]; NaN: none stated


class SensorState(NamedTuple):
    """How one sensor is seen."""

    sensor: str  # name
    level: SensorLevel  # how it is seen
    reason: str  # why, empty when OK
    age: float  # of the newest accepted reading [s], infinite before the first
    accepted: int  # readings so far
    refused: int  # readings so far
    alarm: Alarm | None = None  # its fault, where its level is `suspect` or `lost`

    def reported(self, loop: str) -> SensorState:
        """Return it with what the `loop` does in its alarm."""
        return self if self.alarm is None else self._replace(alarm=self.alarm.reported(loop))


class Report(NamedTuple):
    """See heave_msgs/ControllerState, whose names these are: the controller's estimates and actions.

    `is_inhibited`, for diagnostics: compensation is harmful, or would, and is kept off.
    """

    mode: str
    law: str
    reason: str
    state_names: tuple[str, ...]
    estimate: tuple[float, ...]
    covariance_diagonal: tuple[float, ...]
    measurement_names: tuple[str, ...]
    innovation: tuple[float, ...]
    innovation_sigma: tuple[float, ...]
    nis: tuple[float, ...]
    gain: tuple[float, ...]
    predicted_unit_heave: float
    predicted_boom_tip_heave: float
    predicted_uncompensated_heave: float
    payout_set_point: float
    payout_rate_set_point: float
    depth_set_point: float
    authority: float
    active_limits: tuple[str, ...]
    solver_status: str
    solver_iterations: int
    sensors: tuple[SensorState, ...]
    is_inhibited: bool = False


@dataclass(frozen=True)
class RollingKpi:
    """See heave_msgs/CompensationKpi, whose names these are: figures of merit from sensors and estimates alone."""

    window: float
    unit_sigma: float
    uncompensated_sigma: float
    boom_tip_sigma: float
    unit_efficiency: float
    outlet_efficiency: float
    significant_residual: float
    max_abs_heave: float
    winch_speed_max: float
    winch_acceleration_max: float
    power_peak: float
    power_mean: float
    tension_min: float
    tension_max: float
    time_at_limit: float


class Outputs(NamedTuple):
    """What a tick gives."""

    order: WinchOrder  # to the winch
    mode: str  # see `Report`
    authority: float  # see `Report`
    depth_set_point: float  # see `Report`
    make_report: Callable[[], Report]  # returns the report of the tick; it is to be asked before the next one
    make_kpi: Callable[[], RollingKpi] | None = None  # returns the figures, once a second; None else
    alarms: tuple[Alarm, ...] = ()  # raised in this tick
    # what an operator has asked for since the last tick, one line each; mode changes are reported apart
    requests: tuple[str, ...] = ()
    make_observations: Callable[[], Observations] | None = None  # for the adviser, once a second; None else

    @property
    def report(self) -> Report:
        """Estimates and actions of the tick, made only when they are read."""
        return self.make_report()

    @property
    def kpi(self) -> RollingKpi | None:
        """Figures of merit, made only when they are read; None but once a second."""
        return None if self.make_kpi is None else self.make_kpi()

    @property
    def observations(self) -> Observations | None:
        """What the adviser is asked about, made only when it is read; None but once a second."""
        return None if self.make_observations is None else self.make_observations()
