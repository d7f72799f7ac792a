"""Parameters of limits, modes, interlocks and sensor gates: of all that laws share. A law's own stand beside it."""

from __future__ import annotations

from dataclasses import dataclass

from heave_node.parameters import ParameterError, parameter


@dataclass(frozen=True)
class LimitParameters:
    """How much of the winch the controller uses, and what the cable must keep."""

    speed_use: float = parameter(
        1.0, unit="", minimum=0.05, maximum=1.0, description="Share of the winch's speed limit that is used."
    )
    acceleration_use: float = parameter(
        1.0, unit="", minimum=0.05, maximum=1.0, description="Share of the winch's acceleration limit that is used."
    )
    payout_margin: float = parameter(
        1.0, unit="m", minimum=0.0, maximum=100.0, description="Distance kept from the ends of the payout range."
    )
    minimum_tension_ratio: float = parameter(
        0.1, unit="", minimum=0.0, maximum=0.95, description="Least tension over static tension; 0 means no bound."
    )
    maximum_tension_ratio: float = parameter(
        0.0,
        unit="",
        minimum=0.0,
        maximum=100.0,
        description="Highest tension over static tension: plans keep it, and above it the winch gives way; 0: none.",
    )


@dataclass(frozen=True)
class GuardParameters:
    """Never worse than off: compensation is faded out when it does harm."""

    window: float = parameter(
        40.0, unit="s", minimum=1.0, maximum=3600.0, description="Memory of the comparison with uncompensated."
    )
    harm_ratio: float = parameter(
        0.9,
        unit="",
        minimum=0.05,
        maximum=10.0,
        description="Fade out above this residual over uncompensated motion.",
    )
    floor: float = parameter(
        0.02, unit="m", minimum=0.0, maximum=10.0, description="Residual, 1 sigma, that is never held to be harm."
    )
    limit_use: float = parameter(
        0.85,
        unit="",
        minimum=0.05,
        maximum=10.0,
        description="Share of the winch's limits that the peaks of the sea may take up under a law that does not keep "
        "the limits by itself; its authority is lowered to that.",
    )
    hold_time: float = parameter(
        60.0, unit="s", minimum=0.0, maximum=86_400.0, description="Time off before compensation is tried again."
    )
    hold_time_limit: float = parameter(
        960.0,
        unit="s",
        minimum=0.0,
        maximum=86_400.0,
        description="Each harm makes the hold time four times longer, up to this.",
    )
    demand_ratio: float = parameter(
        3.0,
        unit="",
        minimum=0.1,
        maximum=100.0,
        description="No try while the sea asks for more than this multiple of the winch's limits (1/3 highest).",
    )


@dataclass(frozen=True)
class LagParameters:
    """Adaptation to the winch's true servo and delay."""

    adaptation: bool = parameter(
        True, unit="", description="Learn servo and delay of the winch from its encoder; not with a gain schedule."
    )
    window: float = parameter(20.0, unit="s", minimum=5.0, maximum=600.0, description="Length of the record used.")
    step: float = parameter(
        0.008,
        unit="s",
        minimum=1e-4,
        maximum=1.0,
        description="Smallest change of time constant or delay that is worth a redesign.",
    )
    largest: float = parameter(
        0.3, unit="s", minimum=0.0, maximum=5.0, description="Largest change of either from what was believed at first."
    )


@dataclass(frozen=True)
class ModeParameters:
    """Times and rates of the mode machine."""

    start: str = parameter(
        "compensating",
        unit="",
        choices=("standby", "compensating"),
        description="Mode the controller goes to by itself once its estimate has settled.",
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
        1.5, unit="s", minimum=0.0, maximum=10.0, description="Time to run on prediction when the MRU is lost."
    )
    resume: bool = parameter(
        True, unit="", description="Compensate again by itself when a lost sensor is back; faults of the winch wait."
    )
    resume_time: float = parameter(
        15.0, unit="s", minimum=0.0, maximum=3600.0, description="Time all sensors must be well before that."
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
        description="Share of the unit's weight that the cable carries after touchdown.",
    )
    touchdown_ratio: float = parameter(
        0.6,
        unit="",
        minimum=0.0,
        maximum=0.99,
        description="The unit has landed when, lowering, the cable carries less than this share of its weight.",
    )
    lift_off_ratio: float = parameter(
        1.0, unit="", minimum=0.1, maximum=1.0, description="The unit hangs when the cable carries this share again."
    )
    lift_height: float = parameter(
        2.0, unit="m", minimum=0.0, maximum=100.0, description="Height the unit is raised to after it was lifted off."
    )
    time_constant: float = parameter(
        2.0, unit="s", minimum=0.1, maximum=600.0, description="Time constant of the tension loop."
    )
    ramp_time: float = parameter(
        8.0, unit="s", minimum=0.1, maximum=600.0, description="Time over which the set-point goes to its new value."
    )
    speed_limit: float = parameter(
        0.3, unit="m/s", minimum=0.001, maximum=10.0, description="Largest correction on top of the boom-tip rate."
    )

    travel: float = parameter(
        3.0,
        unit="m",
        minimum=0.01,
        maximum=1000.0,
        description="Cable that constant tension may pay out or take in, beside what the change of tension needs.",
    )
    hanging: bool = parameter(
        False, unit="", description="Constant tension may be asked for while the unit hangs, which it does not hold."
    )


@dataclass(frozen=True)
class AlarmParameters:
    """Alarms of tension and winch."""

    slack_ratio: float = parameter(
        0.05, unit="", minimum=0.0, maximum=1.0, description="Alarm below this tension over the static one; 0: none."
    )
    tension_ratio: float = parameter(
        1.5, unit="", minimum=0.0, maximum=100.0, description="Alarm above this tension over the static one; 0: none."
    )
    saturation_share: float = parameter(
        0.25, unit="", minimum=0.0, maximum=1.0, description="Alarm when the winch is at its limits for more than this."
    )
    saturation_time: float = parameter(60.0, unit="s", minimum=1.0, maximum=3600.0, description="Memory of that share.")


@dataclass(frozen=True)
class EntryParameters:
    """What must hold before the winch begins to follow the sea."""

    innovation: float = parameter(
        4.0,
        unit="",
        minimum=1.0,
        maximum=1000.0,
        description="No compensation while a sensor is further off its estimate than this, in standard deviations.",
    )
    peak_use: float = parameter(
        0.8,
        unit="",
        minimum=0.01,
        maximum=10.0,
        description="No constant tension while the peaks of the boom tip take more than this share of the limits.",
    )


@dataclass(frozen=True)
class MoveParameters:
    """Moves to another depth."""

    speed: float = parameter(0.5, unit="m/s", minimum=1e-3, maximum=10.0, description="Largest mean speed of a move.")
    acceleration: float = parameter(
        0.05, unit="m/s^2", minimum=1e-4, maximum=5.0, description="Largest mean acceleration of a move."
    )
    jerk_time: float = parameter(
        2.0, unit="s", minimum=0.0, maximum=60.0, description="Time over which acceleration builds up."
    )


@dataclass(frozen=True)
class OperatorParameters:
    """The operator's own speed, as from a joystick, at `move.acceleration`; compensation has the rest of the winch."""

    speed_share: float = parameter(
        0.3, unit="", minimum=0.0, maximum=1.0, description="Share of the winch's speed that an operator may ask for."
    )
    timeout: float = parameter(
        0.5, unit="s", minimum=0.05, maximum=60.0, description="An operator's speed holds so long, then it is zero."
    )


@dataclass(frozen=True)
class ProgrammeParameters:
    """Moves and modes at given times: what an operator would ask for, for scenarios."""

    move_times: tuple[float, ...] = parameter(
        (), unit="s", minimum=0.0, description="Simulated times at which moves start, ascending."
    )
    move_payouts: tuple[float, ...] = parameter(
        (), unit="m", description="Mean payout that each move goes to; as many as move_times."
    )
    move_speeds: tuple[float, ...] = parameter(
        (), unit="m/s", minimum=0.0, description="Largest speed of each move; 0 or none: move.speed."
    )
    mode_times: tuple[float, ...] = parameter(
        (), unit="s", minimum=0.0, description="Simulated times at which modes are asked for, ascending."
    )
    modes: tuple[str, ...] = parameter(
        (),
        unit="",
        choices=("standby", "compensating", "constant_tension", "stopped", "emergency_stop"),
        description="Mode asked for at each of mode_times.",
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
        3, unit="", minimum=2, maximum=1000, description="So many equal readings in a row are a frozen sensor."
    )
    stale_samples: float = parameter(
        3.0, unit="", minimum=1.0, maximum=1000.0, description="A sensor is lost after so many missing readings."
    )
    recover_samples: int = parameter(
        10, unit="", minimum=1, maximum=10_000, description="Good readings in a row that make a lost sensor good again."
    )
    stamp_tolerance: float = parameter(
        0.001, unit="s", minimum=0.0, maximum=1.0, description="A reading may be stamped this much later than now."
    )
    encoder_step: float = parameter(
        0.05, unit="m", minimum=1e-3, maximum=10.0, description="An encoder step further off than this is a jump."
    )
