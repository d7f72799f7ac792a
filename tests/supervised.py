"""Supervision for tests: a guard, a mode machine, or all of it, on ticks whose numbers a test states."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
from heave_core import look
from heave_core.law import SUPERVISING
from heave_core.library import fill, library, new
from heave_core.modes_table import ModeGuard
from heave_core.sense_table import SENSE_DESIGN, SENSE_STATE, TICK, Reason
from heave_node.interface.codes import WinchFault
from heave_node.winch.fault_latch import is_automatic
from winch_controller_node.core.estimation.loop_tick import TensionMean
from winch_controller_node.core.estimation.sense_design import SENSOR
from winch_controller_node.core.supervision import mode_machine
from winch_controller_node.core.supervision.guard import HarmGuard
from winch_controller_node.core.supervision.modes import MODES, Event, Mode, Situation, event_number
from winch_controller_node.core.supervision.supervisor import Supervisor, WinchSituation
from winch_controller_node.design.design import design_controller
from winch_controller_node.node_parameters import WinchControllerParameters

from tests.core_parts import COUNT, part

HARMFUL = {
    "WORSE_THAN_OFF: depth",
    "WORSE_THAN_OFF: swing",
    "WORSE_THAN_OFF: estimate",
    "DRUM_SPEED_OFF",
    "LITTLE_GAIN",
}
"""Names of the alarms by which the guard ends compensation that does harm."""

DT = 0.05


class Seen(NamedTuple):
    """What the guard compares at a tick: the first rows of the core's SEEN."""

    unit: float = 0.0
    unit_rate: float = 0.0
    free: float = 0.0
    free_rate: float = 0.0
    tip: float = 0.0
    tip_rate: float = 0.0
    payout_rate: float = 0.0
    measured: float = math.nan
    noise: float = 0.0
    mean_acceleration: float = 0.0
    drum_error: float = 0.0
    unknown: float = 0.0
    payout: float = 0.0


ATTEMPTS = {"largest_residual": 0.9, "interruption": 0.25, "learnt": 0.0}


def judged(guard, seen, *, fades=False, is_certain=False):
    """Take what is `seen` in a tick, the rows of SEEN, into a look.Guard; return what is found, as a Verdict."""
    on = guard.design, guard.attempt_design, guard.state, guard.attempts
    if is_certain:
        part("inhibit")(guard.attempts)
    part("judge_attempt")(on, seen, fades, guard.found)
    return guard.verdict


class Guard(look.Guard):
    """The guard's statistics alone: no attempt is remembered."""

    def __init__(self, design):
        super().__init__(design, ATTEMPTS)

    def step(self, seen=None, authority=0.0, target=1.0, *, inhibits=False):
        """Return what is found in a tick."""
        self.attempts[0] = np.zeros((), self.attempts.dtype)
        self.attempts["inhibits"] = inhibits
        return judged(self, (*(seen or Seen()), authority, target, inhibits))


class Judge(HarmGuard):
    """The guard of a controller, a tick at a time."""

    def __init__(self, parameters, loop, *, tick_period):
        super().__init__(parameters, loop, tick_period=tick_period)
        self._period, self._time = tick_period, 0.0

    def allow_correction(self, belief):
        """Do not hold against the loop what a wrong `belief` has done."""
        super().allow_correction(belief, self._time)

    def update(self, seen, authority, target=1.0, *, fades=False, certain=None):
        """Take a tick in; `certain`: compensation must be off for this reason."""
        self._time += self._period
        begun = int(self.core.attempts["begun"][0])
        if certain is not None:
            self.note_certain(certain)
        judged(self.core, (*seen, authority, target, 0.0), fades=fades, is_certain=certain is not None)
        if self.core.attempts["begun"][0] != begun:
            self.note()

    def interrupt(self):
        """Count an attempt that the winch has ended; tell whether an operator has to ask now."""
        self.core.attempts["interruptions"] += 1.0
        return self.core.awaits_operator


class Told(NamedTuple):
    """Inputs of the mode machine at a tick, in words and numbers."""

    lost: str = ""
    has_estimate: bool = True
    winch_fault: int = 0
    harm: str = ""
    speed: float = 0.0
    authority_limit: float = 1.0
    is_settled: bool = True
    is_damped_blind: bool = False
    gates: Callable[[], str] = str
    tension: Callable[[], str] = str
    fault_cause: str = ""
    prospect: str = ""
    awaits_operator: bool = False
    resumes_after_fault: bool = False
    envelope: str = ""
    shown_authority: float = 0.0

    @property
    def words(self):
        """The same in words."""
        given = {name: getattr(self, name) for name in Situation._fields if name not in ("gates", "tension")}
        return Situation(**given, gates=self.gates(), tension=self.tension())

    @property
    def numbers(self):
        """The same in numbers, by the rows of the core's SITUATION."""
        return {
            "lost": bool(self.lost),
            "encoder_lost": "encoder" in self.lost,
            "encoder_frozen": "encoder frozen" in self.lost,
            "winch_silent": "encoder stale" in self.lost,
            "has_estimate": self.has_estimate,
            "winch_fault": self.winch_fault,
            "is_emergency": self.winch_fault == WinchFault.EMERGENCY_STOP,
            "is_automatic": is_automatic(self.winch_fault),
            "harm": bool(self.harm),
            "envelope": bool(self.envelope),
            "gates_closed": bool(self.gates()),
            "tension_closed": bool(self.tension()),
            "is_settled": self.is_settled,
            "is_damped_blind": self.is_damped_blind,
            "speed": self.speed,
            "authority_limit": self.authority_limit,
            "shown_authority": self.shown_authority,
        }


class Machine(mode_machine.ModeMachine):
    """The mode machine, a tick at a time."""

    @property
    def may_resume(self):
        """Tell whether a stopped winch may compensate again by itself."""
        missing = library().heave_core_modes_missing(*self._at[:2], event_number(Event.SENSORS_BACK), self._at[2])
        return not missing & ModeGuard.IF_MAY_RESUME

    def step(self, told):
        """Advance a tick with the inputs `told`."""
        fill(self.situation[0], told.numbers)
        event = part("step_modes", result=COUNT)(*self._at[:3])
        before = int(self.state["before"][0])
        self.state["before"] = self.state["mode"]
        self._look = lambda: told.words
        output = self.follow(event, before)
        return output._replace(reason=self.reason)


@lru_cache
def designed(law="lqg", **parameters):
    """Return the design of a controller."""
    return design_controller(WinchControllerParameters(law=law, **parameters), tick_period=DT)


class Supervised:
    """Supervision of a loop in which all is well and at rest, but for what a test states.

    Attributes
    ----------
    supervisor : on this tick
    """

    def __init__(self, design=None, mode=Mode.COMPENSATING, wants=True):
        self.design = design or designed()
        self._sense, self._sensed, self._tick = new(SENSE_DESIGN), new(SENSE_STATE), new(TICK)
        for name, place in SENSOR.items():
            if name in self._sense.dtype.names:
                self._sense[name] = place
        self._sensed["excluded"], self._excluded = -1, {}
        self._depths = np.zeros((8, 2))
        self.supervisor = Supervisor(self.design, self.design.make_law(), lambda: self._now)
        records = {"sense": self._sense, "sense_state": self._sensed, "tick": self._tick, **self.supervisor.records}
        self._on, self._seen = tuple(records[name] for name in SUPERVISING), records["seen"][0]
        self._now = None
        self.number = 0
        self.enter(mode, wants=wants)

    def enter(self, mode, *, authority=0.0, wants=True):
        """Go to a `mode`."""
        modes = self.supervisor.modes
        modes.mode = mode
        numbers = {"mode": MODES.index(mode), "before": MODES.index(mode), "wants": wants, "authority": authority}
        for name, value in numbers.items():
            modes.state[name] = value

    def step(self, *, lost=(), depths=(), winch=None, **tick):
        """Do a tick; return the decision.

        Parameters
        ----------
        lost : sensors, with the reason by name
        depths : (stamp, depth) that have been read
        winch : fields of WinchSituation, and of the core's SupervisionSeen
        tick : fields of the core's Tick and Motions
        """
        self.number += 1
        lost = lost if isinstance(lost, dict) else dict.fromkeys(lost, "stale")
        usual = {"knows_tip": 1, "knows_sea": 1, "has_encoder": 1, "has_depth": 1, "sees_landing": 1}
        unknown = dict.fromkeys(
            ("tension", "filtered_tension", "tension_mean", "depth_heave", "depth_innovation"), math.nan
        )
        given = {"number": self.number, **usual, **unknown, **tick}
        row = self._tick[0]
        for name, value in given.items():
            (row["motions"] if name in row["motions"].dtype.names else row)[name] = value
        row["lost_sensors"] = sum(1 << SENSOR[name] for name in lost)
        for name, reason in lost.items():
            self._sensed["gates"][0, SENSOR[name]]["reason"] = Reason.STALE if reason == "stale" else Reason.FROZEN
        row["depth_count"] = len(depths)
        self._depths[: len(depths)] = np.reshape(depths, (len(depths), 2))
        mean = TensionMean(float(row["tension_mean"]), float(row["tension_sigma"]), float(row["tension_time"]))
        words = SimpleNamespace(
            number=self.number,
            lost={**self._excluded, **lost},
            inconsistency="the depth is inconsistent" if row["disagree_time"] else "",
            is_sea_refuted=bool(row["is_sea_refuted"]),
            filtered_tension=float(row["filtered_tension"]),
            mean_tension=mean,
        )
        values = {"fault": 0, "mean_payout": 0.0, "settled_swing": math.inf, "share": 1.0, **(winch or {})}
        situation = WinchSituation(**{name: one for name, one in values.items() if name in WinchSituation._fields})
        assert set(values) <= {*WinchSituation._fields, *self._seen.dtype.names}
        seen = {**values, "is_certain": situation.inhibition is not None, "envelope": bool(situation.envelope)}
        seen["is_proved"] = not situation.proof_gate
        for name in self._seen.dtype.names:
            self._seen[name] = seen.get(name, 0.0)
        part("supervise")(self._on, self._depths)
        self._now = words, situation
        return self.supervisor.decided()

    def exclude(self, sensor):
        """Exclude a `sensor`."""
        self._sensed["excluded"], self._excluded = SENSOR[sensor], {sensor: "contradicts all others"}

    def run(self, seconds, **given):
        """Return the alarms of so many `seconds`."""
        return [alarm for _ in range(round(seconds / DT)) for alarm in self.step(**given).alarms]
