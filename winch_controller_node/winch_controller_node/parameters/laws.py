"""Parameters of limits, modes, interlocks and sensor gates: of all that laws share. A law's own are beside it."""

from __future__ import annotations

from dataclasses import dataclass

from heave_node.parameters import ParameterError, parameter


@dataclass(frozen=True)
class LimitParameters:
    """How much of the winch the controller uses, and what the cable must keep."""

    payout_margin: float = parameter(
        1.0, unit="m", minimum=0.0, maximum=100.0, description="Margin kept to the ends of the payout range."
    )
    minimum_tension_ratio: float = parameter(
        0.1,
        unit="",
        minimum=0.0,
        maximum=0.95,
        description="Lowest tension as a fraction of static tension; 0 means no bound.",
    )
    maximum_tension_ratio: float = parameter(
        0.0,
        unit="",
        minimum=0.0,
        maximum=100.0,
        description="Highest tension as a multiple of static tension: plans respect it, and above it the winch pays "
        "out. Where compensation needs more in the sea that is seen it is not kept (TENSION_LIMIT_LOW); 0: none.",
    )

    def __post_init__(self) -> None:
        if 0.0 < self.maximum_tension_ratio < 1.0:
            raise ParameterError(
                f"limits.maximum_tension_ratio = {self.maximum_tension_ratio:g} can never be kept: the unit at rest "
                "hangs on 1 times the static tension; give more than 1, such as 1.5, or 0 for no highest tension"
            )


@dataclass(frozen=True)
class GuardParameters:
    """Never worse than off: compensation is faded out when it is harmful."""

    window: float = parameter(
        40.0,
        unit="s",
        minimum=1.0,
        maximum=3600.0,
        description="Time constant of the comparison with uncompensated motion.",
    )
    harm_ratio: float = parameter(
        0.9,
        unit="",
        minimum=0.05,
        maximum=10.0,
        description=(
            "Fade out when residual over uncompensated motion exceeds this; under an authority A below 1, when it "
            "exceeds 1 - A (1 - harm_ratio)."
        ),
    )
    floor: float = parameter(
        0.02,
        unit="m",
        minimum=0.0,
        maximum=10.0,
        description="Residual, 1 sigma, below which compensation is never judged harmful.",
    )
    limit_use: float = parameter(
        0.85,
        unit="",
        minimum=0.05,
        maximum=10.0,
        description="Fraction of the winch's limits that the peaks of the sea may use under a law that does not "
        "respect the limits by itself; its authority is reduced to that.",
    )
    hold_time: float = parameter(
        60.0,
        unit="s",
        minimum=0.0,
        maximum=86_400.0,
        description="Time without compensation after harm, before it is tried again.",
    )
    hold_time_limit: float = parameter(
        960.0,
        unit="s",
        minimum=0.0,
        maximum=86_400.0,
        description="Each harmful attempt makes the hold time four times longer, up to this.",
    )
    demand_ratio: float = parameter(
        3.0,
        unit="",
        minimum=0.1,
        maximum=100.0,
        description="No attempt while the significant amplitude of the boom tip demands more than this multiple of the "
        "winch's limits.",
    )


@dataclass(frozen=True)
class LagParameters:
    """Adaptation to the winch's true servo, delay, gain and limits."""

    adaptation: bool = parameter(
        True,
        unit="",
        description="Identify lag, delay, gain and limits of the winch by its encoder; not with a gain schedule.",
    )
    window: float = parameter(
        20.0, unit="s", minimum=5.0, maximum=600.0, description="Length of the record by which the winch is identified."
    )
    largest: float = parameter(
        0.3,
        unit="s",
        minimum=0.0,
        maximum=5.0,
        description="Largest delay of commands beyond the nominal one: above it compensation ends.",
    )


@dataclass(frozen=True)
class ModeParameters:
    """Times and rates of the mode machine."""

    start: str = parameter(
        "compensating",
        unit="",
        choices=("standby", "compensating"),
        description="Mode that the controller enters by itself once its estimate has settled.",
    )
    settling_time: float = parameter(
        20.0, unit="s", minimum=0.0, maximum=3600.0, description="Time the estimator runs before compensation starts."
    )
    fade_in_time: float = parameter(
        10.0, unit="s", minimum=0.05, maximum=600.0, description="Time over which compensation is faded in."
    )
    fade_out_time: float = parameter(
        10.0, unit="s", minimum=0.05, maximum=600.0, description="Time over which compensation is faded out."
    )
    coast_time: float = parameter(
        1.5,
        unit="s",
        minimum=0.0,
        maximum=10.0,
        description="Time for which prediction replaces a lost MRU or encoder before compensation fades out.",
    )
    resume: bool = parameter(
        True,
        unit="",
        description="Resume compensation automatically after a lost sensor or a command timeout of the winch; other "
        "winch faults wait for an operator.",
    )
    resume_time: float = parameter(
        15.0,
        unit="s",
        minimum=0.0,
        maximum=3600.0,
        description="Time for which all sensors must be good before a winch that has stopped for one resumes.",
    )
    stop_deceleration: float = parameter(
        0.5, unit="m/s^2", minimum=1e-3, maximum=100.0, description="Deceleration of an orderly stop."
    )


@dataclass(frozen=True)
class TensionLawParameters:
    """The constant-tension mode and landing."""

    landing_ratio: float = parameter(
        0.2,
        unit="",
        minimum=0.0,
        maximum=0.95,
        description="Fraction of the unit's weight that the cable carries after touchdown.",
    )
    touchdown_ratio: float = parameter(
        0.6,
        unit="",
        minimum=0.0,
        maximum=0.99,
        description="The unit has landed when, lowering, the cable carries less than this fraction of its weight.",
    )
    lift_height: float = parameter(
        2.0, unit="m", minimum=0.0, maximum=100.0, description="Height to which the unit is raised after lift-off."
    )
    time_constant: float = parameter(
        2.0, unit="s", minimum=0.1, maximum=600.0, description="Time constant of the tension loop."
    )
    ramp_time: float = parameter(
        8.0,
        unit="s",
        minimum=0.1,
        maximum=600.0,
        description="Time over which the set-point is ramped to its new value.",
    )
    speed_limit: float = parameter(
        0.3, unit="m/s", minimum=0.001, maximum=10.0, description="Largest correction added to the boom-tip rate."
    )

    travel: float = parameter(
        3.0,
        unit="m",
        minimum=0.01,
        maximum=1000.0,
        description="Cable that constant tension may pay out or haul in, beyond what the change of tension requires.",
    )
    hanging: bool = parameter(
        False,
        unit="",
        description="Allow constant tension while the unit is suspended, although it does not hold the unit.",
    )


@dataclass(frozen=True)
class AlarmParameters:
    """Alarms of tension and winch."""

    slack_ratio: float = parameter(
        0.05, unit="", minimum=0.0, maximum=1.0, description="Alarm below this fraction of static tension; 0: none."
    )
    tension_ratio: float = parameter(
        1.5, unit="", minimum=0.0, maximum=100.0, description="Alarm above this multiple of static tension; 0: none."
    )
    saturation_share: float = parameter(
        0.25,
        unit="",
        minimum=0.0,
        maximum=1.0,
        description="Alarm when the winch is at its limits for more than this fraction of the time.",
    )
    saturation_time: float = parameter(
        60.0, unit="s", minimum=1.0, maximum=3600.0, description="Averaging time of that fraction."
    )


@dataclass(frozen=True)
class EntryParameters:
    """What must hold before the winch begins to follow the sea."""

    peak_use: float = parameter(
        0.8,
        unit="",
        minimum=0.01,
        maximum=10.0,
        description="No constant tension while the peaks of the boom tip use more than this fraction of the limits; "
        "compensation begins all the same, and reports with what authority.",
    )
    accept_unproved: bool = parameter(
        False,
        unit="",
        description="Begin compensation although neither load cell nor depth sensor has proved the MRU: an operator's "
        "consent, stated beforehand. One that is proved to be reversed is refused all the same.",
    )


@dataclass(frozen=True)
class MoveParameters:
    """Moves to another depth."""

    speed: float = parameter(0.5, unit="m/s", minimum=1e-3, maximum=10.0, description="Largest mean speed of a move.")
    acceleration: float = parameter(
        0.05, unit="m/s^2", minimum=1e-4, maximum=5.0, description="Largest mean acceleration of a move."
    )
    jerk_time: float = parameter(
        2.0, unit="s", minimum=0.0, maximum=60.0, description="Time over which acceleration ramps up."
    )


@dataclass(frozen=True)
class OperatorParameters:
    """The operator's own speed, as from a joystick: its shares of the winch; compensation has the rest."""

    speed_share: float = parameter(
        0.3,
        unit="",
        minimum=0.0,
        maximum=1.0,
        description="Fraction of the winch's active speed limit available to an operator; compensation has the rest.",
    )
    acceleration_share: float = parameter(
        0.035,
        unit="",
        minimum=0.001,
        maximum=1.0,
        description="Fraction of the winch's active acceleration limit available to an operator; compensation has "
        "the rest.",
    )
    timeout: float = parameter(
        0.5,
        unit="s",
        minimum=0.05,
        maximum=60.0,
        description="Time for which an operator's speed command holds; then it becomes zero.",
    )


@dataclass(frozen=True)
class ProgrammeParameters:
    """Moves and modes at given times: what an operator would ask for, for scenarios."""

    move_times: tuple[float, ...] = parameter(
        (),
        unit="s",
        minimum=0.0,
        description="Simulated times at which moves start, ascending; one that is due while the brake is on waits for "
        "compensation, or for the next one to take its place.",
    )
    move_payouts: tuple[float, ...] = parameter(
        (), unit="m", description="Target mean payout of each move; one per move_times."
    )
    move_speeds: tuple[float, ...] = parameter(
        (), unit="m/s", minimum=0.0, description="Largest speed of each move; 0 or none: move.speed."
    )
    mode_times: tuple[float, ...] = parameter(
        (), unit="s", minimum=0.0, description="Simulated times at which modes are requested, ascending."
    )
    modes: tuple[str, ...] = parameter(
        (),
        unit="",
        choices=("standby", "compensating", "constant_tension", "stopped", "emergency_stop"),
        description="Mode requested at each of mode_times.",
    )

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

    frozen_samples: int = parameter(
        3,
        unit="",
        minimum=2,
        maximum=1000,
        description="Number of equal readings in a row that mark a sensor as frozen.",
    )
    stale_samples: float = parameter(
        3.0,
        unit="",
        minimum=1.0,
        maximum=1000.0,
        description="Number of missing readings after which a sensor is lost.",
    )
    recover_samples: int = parameter(
        10,
        unit="",
        minimum=1,
        maximum=10_000,
        description="Number of good readings in a row after which a lost sensor is good again.",
    )
    stamp_tolerance: float = parameter(
        0.001,
        unit="s",
        minimum=0.0,
        maximum=1.0,
        description="Largest time by which the stamp of a reading may be ahead of now.",
    )
    encoder_step: float = parameter(
        0.05, unit="m", minimum=1e-3, maximum=10.0, description="Deviation above which an encoder step is a jump."
    )
    payout_tolerance: float = parameter(
        0.01,
        unit="",
        minimum=0.0,
        maximum=1.0,
        description="Difference of depth sensor and payout that may be, over the cable that is out, beside 3 m of tide "
        "and draught; 0: none is reported.",
    )
