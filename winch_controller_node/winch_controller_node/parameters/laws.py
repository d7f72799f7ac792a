"""Parameters of limits, modes, interlocks and sensor gates: of all that laws share. A law's own are beside it."""

from __future__ import annotations

from dataclasses import dataclass

from heave_node.parameters import ParameterError, parameter


@dataclass(frozen=True)
class LimitParameters:
    """How much of the winch the controller uses, and what the cable must keep."""

    payout_margin: float = parameter(1.0, "m", 0.0, 100.0, "Margin kept to the ends of the payout range.")
    minimum_tension_ratio: float = parameter(0.1, "", 0.0, 0.95,
        "Lowest tension as a fraction of static tension; 0: no bound.")  # fmt: skip
    maximum_tension_ratio: float = parameter(0.0, "", 0.0, 100.0,
        "Highest tension as a multiple of static tension: plans keep it, and above it the winch pays "
        "out, unless the sea requires more (TENSION_LIMIT_LOW); 0: none.")  # fmt: skip

    def __post_init__(self) -> None:
        if 0.0 < self.maximum_tension_ratio < 1.0:
            raise ParameterError(
                f"limits.maximum_tension_ratio = {self.maximum_tension_ratio:g} can never be kept: the unit at rest "
                "hangs on 1 times the static tension; give more than 1, such as 1.5, or 0 for no highest tension"
            )


@dataclass(frozen=True)
class GuardParameters:
    """Never worse than off: compensation is faded out when it is harmful."""

    window: float = 40.0  # time constant of the comparison with uncompensated motion [s]
    harm_ratio: float = parameter(0.9, "", 0.05, 10.0,
        "Compensation fades out when more than this fraction of the uncompensated motion remains; with a "
        "gain A below 1, more than 1 - A (1 - harm_ratio). No attempt if more is predicted.")  # fmt: skip
    floor: float = parameter(0.02, "m", 0.0, 10.0,
        "Residual, 1 sigma, below which compensation is never judged harmful.")  # fmt: skip
    limit_use: float = parameter(0.85, "", 0.05, 10.0,
        "Fraction of the winch limits that boom-tip peaks may use under a law without a plan; its gain is "
        "reduced accordingly.")  # fmt: skip


@dataclass(frozen=True)
class LagParameters:
    """Adaptation to the winch's true servo, delay, gain and limits."""

    adaptation: bool = parameter(True,
        description="Identify lag, delay, gain and limits of the winch from its encoder.")  # fmt: skip
    window: float = 20.0  # length of the record by which the winch is identified [s]
    largest: float = parameter(0.3, "s", 0.0, 5.0,
        "Largest delay of commands beyond the nominal one: above it compensation ends.")  # fmt: skip


@dataclass(frozen=True)
class ModeParameters:
    """Times and rates of the mode machine."""

    start: str = parameter("compensating",
        description="Mode that the controller enters automatically once its estimate has settled.",
        choices=("standby", "compensating"))  # fmt: skip
    settling_time: float = parameter(20.0, "s", 0.0, 3600.0, "Time the estimator runs before compensation starts.")
    fade_in_time: float = parameter(10.0, "s", 0.05, 600.0, "Time over which compensation is faded in.")
    fade_out_time: float = parameter(10.0, "s", 0.05, 600.0, "Time over which compensation is faded out.")
    coast_time: float = parameter(1.5, "s", 0.0, 10.0,
        "Time for which prediction replaces a lost MRU or encoder before compensation fades out.")  # fmt: skip
    resume: bool = parameter(True,
        description="Resume compensation automatically after a lost sensor or a command timeout of the winch; other "
        "winch faults wait for an operator.")  # fmt: skip
    resume_time: float = parameter(15.0, "s", 0.0, 3600.0,
        "Time for which all sensors must be good before a winch that stopped for a lost sensor resumes.")  # fmt: skip
    stop_deceleration: float = parameter(0.5, "m/s^2", 1e-3, 100.0, "Deceleration of an orderly stop.")


@dataclass(frozen=True)
class TensionLawParameters:
    """The constant-tension mode and landing."""

    landing_ratio: float = 0.2  # fraction of the load's weight that the cable carries after touchdown [-]
    touchdown_ratio: float = parameter(0.6, "", 0.0, 0.99,
        "Touchdown: a lowered load leaves less than this fraction of its weight on the cable.")  # fmt: skip
    lift_height: float = parameter(2.0, "m", 0.0, 100.0, "Height to which the unit is raised after lift-off.")
    time_constant: float = 2.0  # time constant of the tension loop [s]
    ramp_time: float = 8.0  # time over which the set-point is ramped to its new value [s]
    speed_limit: float = 0.3  # largest correction added to the boom-tip rate [m/s]

    travel: float = parameter(3.0, "m", 0.01, 1000.0,
        "Cable that constant tension may pay out or haul in, beyond what the change of tension requires.")  # fmt: skip
    hanging: bool = parameter(False,
        description="Allow constant tension while the unit is suspended, although it does not hold the unit.",
    )  # fmt: skip


@dataclass(frozen=True)
class AlarmParameters:
    """Alarms of tension and winch."""

    slack_ratio: float = 0.05  # alarm below this fraction of static tension [-]; 0: none
    tension_ratio: float = parameter(1.5, "", 0.0, 100.0, "Alarm above this multiple of static tension; 0: none.")
    # alarm when the winch is at its limits for more than this fraction of the time [-]
    saturation_share: float = 0.25
    saturation_time: float = 60.0  # averaging time of that fraction [s]


@dataclass(frozen=True)
class EntryParameters:
    """What must hold before the winch begins to follow the sea."""

    peak_use: float = parameter(0.8, "", 0.01, 10.0,
        "Fraction of the winch limits that boom-tip peaks may use. Above it, constant tension is "
        "refused, and compensation starts with a reduced gain, which it reports.")  # fmt: skip
    accept_unproved: bool = parameter(False,
        description="Start compensation although neither load cell nor depth sensor has confirmed the MRU: the "
        "operator's consent in advance. A reversed MRU is still refused.")  # fmt: skip


@dataclass(frozen=True)
class MoveParameters:
    """Moves to another depth."""

    speed: float = parameter(0.5, "m/s", 1e-3, 10.0, "Largest mean speed of a move.")
    acceleration: float = parameter(0.05, "m/s^2", 1e-4, 5.0, "Largest mean acceleration of a move.")
    jerk_time: float = 2.0  # time over which acceleration ramps up [s]


@dataclass(frozen=True)
class OperatorParameters:
    """The operator's own speed, as from a joystick: its shares of the winch; compensation has the rest."""

    speed_share: float = parameter(0.3, "", 0.0, 1.0,
        "Fraction of the winch's active speed limit for the operator; compensation has the rest.")  # fmt: skip
    acceleration_share: float = parameter(0.035, "", 0.001, 1.0,
        "Fraction of the winch's active acceleration limit for the operator; compensation has the rest.",
    )  # fmt: skip
    timeout: float = parameter(0.5, "s", 0.05, 60.0,
        "Time for which an operator's speed command holds; then it becomes zero.")  # fmt: skip


@dataclass(frozen=True)
class ProgrammeParameters:
    """Moves and modes at given times: what an operator would ask for, for scenarios."""

    move_times: tuple[float, ...] = parameter((), "s", 0.0, None,
        "Simulated times at which moves start, ascending; a move due while the brake is on waits for "
        "compensation, unless the next one replaces it.")  # fmt: skip
    move_payouts: tuple[float, ...] = parameter((), "m",
        description="Target mean payout of each move; one per move_times.")  # fmt: skip
    move_speeds: tuple[float, ...] = parameter((), "m/s", 0.0, None,
        "Largest speed of each move; 0 or none: move.speed.")  # fmt: skip
    mode_times: tuple[float, ...] = parameter((), "s", 0.0, None,
        "Simulated times at which modes are requested, ascending.")  # fmt: skip
    modes: tuple[str, ...] = parameter((),
        description="Mode requested at each of mode_times.",
        choices=("standby", "compensating", "constant_tension", "stopped", "emergency_stop"))  # fmt: skip

    def __post_init__(self) -> None:
        if len(self.move_payouts) != len(self.move_times):
            raise ParameterError("programme.move_payouts must have as many values as programme.move_times")
        if self.move_speeds and len(self.move_speeds) != len(self.move_times):
            raise ParameterError("programme.move_speeds must be empty or have as many values as programme.move_times")
        if len(self.modes) != len(self.mode_times):
            raise ParameterError("programme.modes must have as many values as programme.mode_times")
        for name in ("move_times", "mode_times"):
            times = getattr(self, name)
            if list(times) != sorted(times):
                raise ParameterError(f"programme.{name} must be ascending; got {list(times)}")


@dataclass(frozen=True)
class HealthParameters:
    """Gates in front of the estimator."""

    frozen_samples: int = parameter(3, "", 2, 1000, "Number of equal readings in a row that mark a sensor as frozen.")
    stale_samples: float = 3.0  # number of missing readings after which a sensor is lost [-]
    recover_samples: int = 10  # number of good readings in a row after which a lost sensor is good again
    stamp_tolerance: float = 0.001  # largest time by which the stamp of a reading may be ahead of now [s]
    encoder_step: float = parameter(0.05, "m", 1e-3, 10.0, "Deviation above which an encoder step is a jump.")
    payout_tolerance: float = parameter(0.01, "", 0.0, 1.0,
        "Allowed difference between depth sensor and payout, as a fraction of the rope out, plus 3 m for "
        "tide and draught; 0: not checked.")  # fmt: skip
