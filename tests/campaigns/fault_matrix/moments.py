"""Moments of a lift at which a fault can begin: each mode and each way between two of them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from cable_sim_node.alarms import fault_alarm
from heave_bringup.closed_loop import COLUMNS, ClosedLoop, LoopRecord, loop_parameters
from heave_bringup.scenarios import Scenario
from heave_node.interface.codes import WinchFault
from heave_studies.promise.deviation import Chance, Settings
from winch_controller_node.motion.trajectory import MeanPayout

from tests.campaigns.fault_matrix.wires import Wires

LIFTS = ("b2_calm_300", "b3_deep_900", "b4_limit_900_tp10", "b10_real_mru_swell", "unit_1500")
LANDINGS = ("b7_landing", "b13_landing_soft")

LONGEST = 240.0
"""Time by which a moment is reached [s], or it is not in this case."""

MODE, COLUMN = "mode", {name: place for place, name in enumerate(COLUMNS)}


@dataclass
class Asked:
    """What of the drum's motion was asked for."""

    distance: float = 0.0  # of a move that is under way, paying out positive [m]
    speed: float = 0.0  # its largest speed [m/s]
    travel: float = 0.0  # allowed besides, where the winch holds a tension [m]
    is_to_come: bool = False  # the controller begins it by itself, later

    def left(self, mean: MeanPayout) -> Asked:
        """Return what is left of it as the `mean` payout stands: it comes to its speed, and to rest, smoothly."""
        if math.isinf(self.distance):
            return self
        if mean.has_target:
            return replace(self, distance=mean.target - mean.point.payout)
        return self if self.is_to_come else replace(self, distance=0.0)


@dataclass
class Session:
    """A loop that runs, and what it leaves.

    Parameters
    ----------
    scenario : that is run

    Attributes
    ----------
    loop, wires : it, and what lies between its components
    asked : what an operator or the programme has asked of the drum
    brake, ordered : at each tick: the brake is on; rate that the drive was sent [m/s], NaN: to brake
    only_brake : at each tick: nothing but the brake may hold the drum, after an emergency stop or a fault of the drive
    """

    scenario: Scenario
    asked: Asked = field(default_factory=Asked)
    brake: list[bool] = field(default_factory=list)
    ordered: list[float] = field(default_factory=list)
    only_brake: list[bool] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.loop = ClosedLoop(loop_parameters(self.scenario))
        self.tick_period = self.scenario.run.tick_period
        self.wires = Wires(self.loop, self.tick_period)
        self._rows: list[np.ndarray] = []
        self._modes: list[str] = []
        self._alarms: list[tuple[float, object]] = []
        self._speed = 0.0
        self._fault = WinchFault.NONE

    @property
    def time(self) -> float:
        """Time of the next tick [s]."""
        return self.loop.tick * self.tick_period

    @property
    def mode(self) -> str:
        """Mode after the last tick."""
        return str(self.loop.controller.mode.value)

    @property
    def record(self) -> LoopRecord:
        """What the run has left until now; the drive's own alarms are among those of the controller."""
        return LoopRecord(np.array(self._rows), list(self._modes), list(self._alarms))  # type: ignore[arg-type]

    def step(self) -> None:
        """Do a tick."""
        if self._speed and self.mode in ("manual", "compensating"):
            self.loop.controller.operate(self._speed)
        outputs, row = self.loop.step()
        self._rows.append(row)
        self._modes.append(outputs.mode)
        self._alarms += [(float(row[0]), alarm) for alarm in outputs.alarms]
        state = self.loop.winch.state
        self.brake.append(state.brake)
        self.ordered.append(self.wires.ordered)
        self.only_brake.append(state.fault is not WinchFault.NONE or self.mode == "emergency_stop")
        if state.fault is not self._fault and state.fault is not WinchFault.NONE:
            alarm = fault_alarm(state.fault, state.release, brake=state.brake, cause=self.loop.winch.supervised)
            self._alarms.append((state.time, alarm))
        self._fault = state.fault

    def until(self, condition: Callable[[], bool], within: float = LONGEST) -> bool:
        """Run until a `condition` holds; return whether it did before the time `within` [s]."""
        while self.time < within:
            if condition():
                return True
            self.step()
        return False

    def go(self, duration: float) -> None:
        """Run for a `duration` [s]."""
        for _ in range(round(duration / self.tick_period)):
            self.step()

    def set_mode(self, name: str) -> None:
        """Request a mode, as an operator does."""
        self.loop.controller.set_mode(name)

    def move(self, distance: float, speed: float) -> None:
        """Move the mean payout by a `distance` [m] at a `speed` [m/s]."""
        self.loop.controller.move_to_payout(self.loop.controller.mean.point.payout + distance, speed)
        self.asked = Asked(distance, speed)

    def operate(self, speed: float) -> None:
        """Lower at a `speed` [m/s] from now on, negative lifts."""
        self._speed = speed
        self.asked = Asked(math.copysign(math.inf, speed), abs(speed))

    def last(self, name: str) -> float:
        """Return the last value of a column."""
        return float(self._rows[-1][COLUMN[name]])


def _compensates(session: Session, lasting: float) -> bool:
    if not session.until(lambda: session.mode == "compensating"):
        return False
    session.go(lasting)
    return session.mode == "compensating"


def _standby(session: Session, _: Chance) -> bool:
    session.go(10.0)
    return session.mode == "standby"


def _entry(session: Session, _: Chance) -> bool:
    return session.until(lambda: session.mode == "compensating")


def _compensating(session: Session, _: Chance) -> bool:
    return _compensates(session, 20.0)


def _fade_out(session: Session, _: Chance) -> bool:
    if not _compensates(session, 20.0):
        return False
    session.set_mode("standby")
    return True


def _stopping(session: Session, _: Chance) -> bool:
    return _fade_out(session, _) and session.until(lambda: session.mode == "stopping")


def _emergency_stop(session: Session, _: Chance) -> bool:
    if not _compensates(session, 20.0):
        return False
    session.set_mode("emergency_stop")
    return True


def _move(session: Session, chance: Chance) -> bool:
    if not _compensates(session, 20.0):
        return False
    session.move(chance.sign() * chance.between(4.0, 12.0), chance.between(0.1, 0.4))
    return True


def _manual(session: Session, chance: Chance) -> bool:
    session.go(15.0)
    if session.mode != "standby":
        return False
    session.set_mode("manual")
    session.operate(chance.sign() * chance.between(0.05, 0.3))
    return True


def _near_bottom(session: Session, _: Chance) -> bool:
    bottom = session.scenario.parameters["cable_sim"].seabed.depth
    reached = session.until(lambda: bool(session.brake) and session.last("unit") + bottom < 1.0)
    programme = session.scenario.parameters["winch_controller"].programme
    session.asked = Asked(20.0, programme.move_speeds[-1], _travel(session))
    return reached and session.mode == "compensating"


def _travel(session: Session) -> float:
    return float(session.loop.controller.parameters.tension.travel)


def _constant_tension(session: Session, _: Chance) -> bool:
    reached = session.until(lambda: session.mode == "constant_tension")
    session.asked = Asked(travel=_travel(session))
    return reached


def _lift_off(session: Session, _: Chance) -> bool:
    if not _constant_tension(session, _):
        return False
    session.go(15.0)
    session.set_mode("compensating")
    tension = session.loop.controller.parameters.tension
    session.asked = Asked(-tension.lift_height, 1.0, tension.travel, is_to_come=True)
    return True


@dataclass(frozen=True)
class Moment:
    """A moment at which a fault can begin."""

    name: str  # of it
    reach: Callable[[Session, Chance], bool]  # runs a session until it has begun; False where it does not come
    window: float  # from then on, the fault begins within this time [s]
    scenarios: tuple[str, ...] = LIFTS  # in which it comes

    @property
    def settings(self) -> Settings:
        """Parameters of the run: the sea comes up in 20 s, and a landing begins near the bottom."""
        settings: dict[str, object] = {"wave_vessel.ramp": 20.0}
        if self.scenarios is LANDINGS:
            programme = "winch_controller.programme"
            settings |= {
                f"{programme}.move_times": [70.0],
                f"{programme}.move_payouts": [20.0],
                f"{programme}.move_speeds": [0.15],
                f"{programme}.mode_times": [],
                f"{programme}.modes": [],
            }
        return settings


def depth_of(scenario: str) -> Settings:
    """Return where the bottom is in a `scenario` of a landing: some 5 m below the unit, so that it comes soon."""
    depth = {"b7_landing": 577.5, "b13_landing_soft": 1509.5}.get(scenario)
    return {} if depth is None else {"cable_sim.seabed.depth": depth}


MOMENTS = (
    Moment("standby", _standby, 20.0),
    Moment("entry", _entry, 9.0),
    Moment("compensating", _compensating, 30.0),
    Moment("move", _move, 15.0),
    Moment("fade_out", _fade_out, 9.0),
    Moment("stopping", _stopping, 1.0),
    Moment("emergency_stop", _emergency_stop, 1.5),
    Moment("manual", _manual, 10.0),
    Moment("landing", _near_bottom, 10.0, LANDINGS),
    Moment("constant_tension", _constant_tension, 20.0, LANDINGS),
    Moment("lift_off", _lift_off, 10.0, LANDINGS),
)
"""Modes, and the ways between them."""
