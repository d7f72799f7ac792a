"""What an operator knows of a run: the newest of what its nodes publish, and what that says in words."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

from heave_bags.analyse.verdict import open_loop
from heave_node.interface.codes import MODE

WAITING, RUNNING, PAUSED, ENDED, FAILED = range(5)
"""States of a run, as in heave_msgs/TickStatus."""

STATE_WORDS = {WAITING: "waiting", RUNNING: "running", PAUSED: "paused", ENDED: "ended", FAILED: "failed"}
UNKNOWN = math.nan


@dataclass
class RunStatus:
    """How the run goes, as reported by its clock master."""

    state: int  # WAITING, RUNNING, PAUSED, ENDED or FAILED
    reason: str = ""  # what is waited for, or why it failed
    tick: int = 0  # number of the tick that is under way
    time: float = 0.0  # simulated [s]
    real_time_factor: float = 0.0  # simulated over wall time [-]
    missed_deadlines: int = 0  # ticks whose inputs were not there in time


@dataclass
class ControllerStatus:
    """What the controller says of a tick."""

    time: float  # simulated time of the tick [s]
    mode: str  # as in heave_msgs/ControllerState
    law: str = ""  # as in heave_msgs/ControllerState
    reason: str = ""  # as in heave_msgs/ControllerState
    authority: float = 0.0  # authority of compensation, 0 to 1 [-]
    unit_heave: float = UNKNOWN  # estimated, about their means, positive up [m]
    boom_tip_heave: float = UNKNOWN  # estimated, about their means, positive up [m]
    uncompensated_heave: float = UNKNOWN  # estimated, about their means, positive up [m]
    mean_payout: float = UNKNOWN  # about which compensation works, positive lowers [m]
    limits: tuple[str, ...] = ()  # that shape the command


@dataclass
class WinchStatus:
    """What the winch reports of itself."""

    time: float  # simulated [s]
    payout: float = UNKNOWN  # of the encoder, positive lowers [m]
    rate: float = UNKNOWN  # of the encoder, positive lowers [m/s]
    tension: float = UNKNOWN  # at the drum [N]
    brake: bool = False  # whether it is on
    fault: int = 0  # code, as in heave_msgs/WinchState; 0 for none
    acceleration: float = UNKNOWN  # change of that rate since the state before [m/s^2]

    def since(self, before: WinchStatus | None) -> WinchStatus:
        """Return this with its acceleration, by the rate that was read `before`."""
        if before is None or self.time <= before.time:
            return self
        return replace(self, acceleration=(self.rate - before.rate) / (self.time - before.time))


@dataclass
class Figures:
    """The controller's rolling figures of merit, from its estimates."""

    window: float  # over which they are taken [s]
    unit_sigma: float  # standard deviation of the unit's heave [m]
    uncompensated_sigma: float = UNKNOWN  # the same with the winch locked [m]
    winch_speed_max: float = UNKNOWN  # [m/s]
    tension_min: float = UNKNOWN  # measured [N]
    tension_max: float = UNKNOWN  # measured [N]


@dataclass(frozen=True)
class Trouble:
    """A part of a node that is not well."""

    part: str  # node and part
    message: str  # what is wrong
    is_error: bool  # an alarm; else a warning

    def __str__(self) -> str:
        return f"{self.part}: {self.message}"


@dataclass
class Situation:
    """The newest of each; None where nothing has come yet."""

    run: RunStatus | None = None  # from the run's topics
    controller: ControllerStatus | None = None  # from the run's topics
    winch: WinchStatus | None = None  # from the run's topics
    figures: Figures | None = None  # from the run's topics
    # estimated mean depth of the unit, positive down [m]; NaN where the controller does not know it
    depth: float = UNKNOWN
    load_cell: float = UNKNOWN  # top tension as the load cell measures it [N]; NaN where there is none
    # devices that a node of the run simulates, so that faults can be injected; None: not known yet
    simulated: tuple[str, ...] | None = None
    played: tuple[str, ...] = ()  # nodes in whose place a bag is played
    troubles: dict[str, Trouble] = field(default_factory=dict)  # by part, what /diagnostics says is not well now

    @property
    def tension(self) -> float:
        """Tension as the winch says it [N]; as the load cell does where the winch, a real one, does not."""
        if self.winch is not None and math.isfinite(self.winch.tension):
            return self.winch.tension
        return self.load_cell

    @property
    def is_over(self) -> bool:
        """Whether the run has ended, well or not."""
        return self.run is not None and self.run.state in (ENDED, FAILED)

    @property
    def is_paused(self) -> bool:
        """Whether the run's clock stands."""
        return self.run is not None and self.run.state == PAUSED

    @property
    def time(self) -> float:
        """Newest simulated time that any node has reported [s]."""
        return max((part.time for part in (self.run, self.controller, self.winch) if part is not None), default=0.0)

    @property
    def alarms(self) -> list[Trouble]:
        """What is in error now."""
        return [trouble for trouble in self.troubles.values() if trouble.is_error]

    def note(self, part: str, level: int, message: str) -> None:
        """Take what a node says of a `part` of itself: a `level` of diagnostics (1 warning, 2 error) and a message."""
        if level in (1, 2):
            self.troubles[part] = Trouble(part, message, level == 2)
        else:
            self.troubles.pop(part, None)


def run_words(run: RunStatus | None) -> str:
    """Say how the `run` goes."""
    if run is None:
        return "no data from the clock master"
    if run.state == WAITING:
        return f"waiting for {run.reason or 'the nodes'}"
    where = f"{STATE_WORDS[run.state]} at t = {run.time:.2f} s (tick {run.tick})"
    if run.state == RUNNING:
        return f"{where}, {run.real_time_factor:.1f} x real time"
    return f"{where}: {run.reason}" if run.reason else where


def mode_words(controller: ControllerStatus) -> str:
    """Say the mode of the `controller` and, where it is not simply at work, why."""
    words = f"mode {controller.mode} (law {controller.law}, gain {controller.authority:.2f})"
    return f"{words}: {controller.reason}" if controller.reason and controller.mode != "compensating" else words


def status_line(situation: Situation) -> str:
    """Say a `situation` in one line."""
    parts = [run_words(situation.run)]
    controller = situation.controller
    if controller is not None:
        parts.append(mode_words(controller))
    if recorded := open_loop(situation.played):
        parts.append(recorded)
    else:
        parts += _motion(situation)
    if situation.is_paused and controller is None:
        parts.append("nodes publish nothing while it is paused: step to see more")
    # the mode stands above, with its reason
    alarms = [str(alarm) for alarm in situation.alarms if controller is None or not alarm.part.endswith(f": {MODE}")]
    parts.append(f"alarms: {', '.join(alarms)}" if alarms else "no alarm")
    return "; ".join(parts)


def _motion(situation: Situation) -> list[str]:
    """Say how load and winch stand and move in a `situation`, as far as it is known."""
    parts, winch, figures = [], situation.winch, situation.figures
    if math.isfinite(situation.depth):
        parts.append(f"mean depth {situation.depth:.2f} m")
    if winch is not None:
        parts.append(f"payout {winch.payout:.2f} m at {winch.rate:+.3f} m/s, brake {'on' if winch.brake else 'off'}")
    if figures is not None and math.isfinite(figures.unit_sigma):
        heave = f"{100.0 * figures.unit_sigma:.2f} cm over {figures.window:.0f} s"
        parts.append(f"load heave, standard deviation {heave}, as estimated")
    return parts
