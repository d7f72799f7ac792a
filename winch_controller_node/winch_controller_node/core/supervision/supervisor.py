"""Supervision of a tick, in words: what is decided is in C++ (`heave_core`, supervise.cpp), a bit for each event."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from heave_core.library import fill, library, new
from heave_core.modes_table import SUPERVISED, SUPERVISION_DESIGN, SUPERVISION_SEEN, SUPERVISION_STATE, Gate, Happened
from heave_node.interface.alarm import Alarm
from heave_node.interface.codes import COMPENSATION_LOST, MODE_CHANGED, REQUESTED

from winch_controller_node.core.estimation.loop_tick import TENSION_MEMORY, LoopTick
from winch_controller_node.core.supervision.guard import HarmGuard, too_much
from winch_controller_node.core.supervision.guard_checks import PEAK, GuardedLoop
from winch_controller_node.core.supervision.landing import EVENTS, HangingLoad, Landing, LandingEvent
from winch_controller_node.core.supervision.mode_machine import ModeMachine
from winch_controller_node.core.supervision.modes import BRAKED, Mode, ModeOutput, Situation
from winch_controller_node.core.supervision.supervision_design import (
    PEAK_OVER_SIGNIFICANT,
    required_sensors,
    supervision_design,
)
from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.laws.law import ControlLaw
from winch_controller_node.laws.parts.winch_limits import WinchLimits

ENDED = (*BRAKED, Mode.FADE_OUT, Mode.STOPPING)
"""Modes in which the unit is not held still."""

SEA_UNKNOWN = "boom-tip motion does not match the assumed sea"
GAIN_UNKNOWN = "gain of the winch or scale of the encoder is not known"
"""What keeps authority low before the guard sees errors of it."""

BEFORE, EVENT, AUTHORITY, IS_INHIBITED, IS_DAMPED, HAPPENED = (
    [row.name for row in SUPERVISED.rows].index(name)
    for name in ("before", "event", "authority", "is_inhibited", "is_damped", "happened")
)
"""Places in what is decided."""

ASK_AGAIN = "check the cause, then request compensation"
"""Ends the reason of an inhibition that only an operator can end."""


class WinchSituation(NamedTuple):
    """What is known of the winch and its commands in a tick, for words."""

    fault: int  # the winch's own, 0 without
    mean_payout: float  # that the winch goes to [m]
    share: float = 1.0  # authority that is best with the winch as it is known, above 0 [-]
    inhibition: Alarm | None = None  # why compensation must be off; None: it need not
    fault_cause: str = ""  # why the winch has its fault, in words; empty: unknown
    # drum or encoder are reversed: the winch is brought to rest until an operator releases it
    is_reversed: bool = False
    envelope: str = ""  # why the envelope has taken over, in words; empty: it has not
    proof_gate: str = ""  # why compensation may not begin by the proofs, in words; empty where it may
    cell_jumped: bool = False  # the load cell is off by a jump that no operator knows of


class Decision(NamedTuple):
    """What supervision has decided in a tick."""

    mode: ModeOutput  # with authority and brake
    is_inhibited: bool  # the guard keeps compensation off
    is_damped: bool  # the unit is damped while compensation fades out
    landing: LandingEvent | None = None  # what has just happened to the unit; None: nothing
    alarms: tuple[Alarm, ...] = ()  # raised in this tick


class Supervisor:
    """Decides what the controller does.

    Parameters
    ----------
    design : the active one; law : of it
    look : returns what the last tick and the winch are, for words; None: there was no tick yet

    Attributes
    ----------
    records : arrays by the names of SUPERVISING in `heave_core.law`
    """

    def __init__(
        self,
        design: ControllerDesign,
        law: ControlLaw,
        look: Callable[[], tuple[LoopTick, WinchSituation] | None],
    ) -> None:
        parameters, dt = design.parameters, design.tick_period
        # for requests of the operator
        self.modes = ModeMachine(
            *(parameters.modes, self._situation),
            moves_winch=law.moves_winch,
            factor=parameters.factor,
            tick_period=dt,
        )
        self._look = look
        # whether compensation is harmful
        self.guard = HarmGuard(parameters.guard, guarded_loop(design, law), tick_period=dt)
        self.landing = Landing(parameters.tension, hanging_load(design))  # whether the unit stands
        self._alarm_before, self._was_inhibited, self._dt = "", False, dt
        self._design, self._state = new(SUPERVISION_DESIGN), new(SUPERVISION_STATE)
        self.done = np.zeros(len(SUPERVISED.rows))
        guard, landing, modes = self.guard.core, self.landing.core, self.modes
        self.records = {
            **{"design": self._design, "state": self._state, "seen": new(SUPERVISION_SEEN), "done": self.done},
            **{"landing": landing.design, "landing_state": landing.state},
            **{"guard": guard.design, "guard_state": guard.state, "verdict": guard.found},
            **{"attempt_design": guard.attempt_design, "attempts": guard.attempts},
            **{"modes": modes.design, "mode": modes.state, "situation": modes.situation},
        }
        self._core, self._state_at = library(), self._state.ctypes.data
        self._core.heave_core_supervision_begin(self._state_at)
        self._refer_to(design)

    def take_design(self, design: ControllerDesign, law: ControlLaw) -> None:
        """Supervise another design and its law from now on."""
        self.guard.take_loop(guarded_loop(design, law))
        self.landing.take_load(hanging_load(design))
        self._refer_to(design)

    def reset_sea(self) -> None:
        """Look at the sea again: what was seen until now was another one."""
        self.guard.reset_sea()
        self._core.heave_core_supervision_reset_sea(self._state_at)

    def _refer_to(self, design: ControllerDesign) -> None:
        self._parameters, self._load, self._limits = design.parameters, hanging_load(design), design.limits
        fill(self._design[0], supervision_design(design, self._load))

    def cancel_timeout(self) -> None:
        """Leave a winch that has stopped for want of commands to the operator, who has asked for something."""
        self._state["is_pending"] = 0

    @property
    def authority(self) -> float:
        """Authority of compensation in the last tick."""
        return float(self.done[AUTHORITY])

    def go_on(self) -> None:
        """Take that nothing has happened in a tick of which words are to be made."""
        self._was_inhibited = bool(self.done[IS_INHIBITED])
        self.modes.go_on()

    def decided(self) -> Decision:
        """Return what was decided in the last tick, and what has happened; to be asked once."""
        bits = int(self.done[HAPPENED])
        alarms = self._alarms(bits, *self._now()) if bits else ()
        mode = self.modes.follow(int(self.done[EVENT]), int(self.done[BEFORE]))
        if mode.before is not None:
            alarms += (mode_alarm(mode),)
        if bits & Happened.SEA_ABOVE_WINCH:
            alarms += self._peaks_alarm()
        if bits & Happened.LOWERS_BLIND:
            alarms += (self._lowering_alarm(self._now()[0]),)
        self._was_inhibited = bool(self.done[IS_INHIBITED])
        landing = EVENTS[self.landing.event] if bits & Happened.UNIT_EVENT else None
        return self._decision(mode)._replace(landing=landing, alarms=alarms)

    def decided_in(self, mode: Mode) -> Decision:
        """Return what was decided in the last tick, in whose `mode` nothing has happened."""
        return self._decision(ModeOutput(mode, "", self.authority, mode in BRAKED))

    def _decision(self, mode: ModeOutput) -> Decision:
        """Return the decision of the last tick, with its `mode`."""
        return Decision(mode, bool(self.done[IS_INHIBITED]), bool(self.done[IS_DAMPED]))

    # in words

    def _now(self) -> tuple[LoopTick, WinchSituation]:
        """Return what the last tick and the winch are."""
        now = self._look()
        assert now is not None, "words are made of a tick"
        return now

    def _situation(self) -> Situation:
        """Return what winch, guard, gates and sensors are in the last tick."""
        if (now := self._look()) is None:
            return Situation()
        tick, winch = now
        guard, is_reversed = self.guard, winch.is_reversed
        lost = lost_sensors(tick, winch)
        return Situation(
            lost=", ".join(f"{name} {lost[name]}" for name in required_sensors(self.modes.mode) if name in lost),
            winch_fault=winch.fault,
            fault_cause=winch.fault_cause,
            harm=f"{guard.reason}; {ASK_AGAIN}" if is_reversed else guard.reason,
            prospect="" if is_reversed else guard.prospect,
            awaits_operator=is_reversed or guard.awaits_operator,
            resumes_after_fault=bool(self._state["is_pending"][0]),
            is_damped_blind=bool(self.modes.situation["is_damped_blind"][0]),
            envelope=winch.envelope,
            gates=self._closed_gates(tick, winch),
            tension=self._why_no_tension(tick, winch),
        )

    def _alarms(self, happened: int, tick: LoopTick, winch: WinchSituation) -> tuple[Alarm, ...]:
        """Return the alarms of what has `happened` in a tick, up to its mode."""
        found: list[Alarm] = []
        if winch.inhibition:
            self.guard.note_certain(winch.inhibition)
        if happened & Happened.LOAD_NOT_HANGING:
            found.append(self._load_alarm)
        if happened & Happened.DEPTH_NOT_PAYOUT:
            depth, out = float(self._state["mean_depth"][0]), self._parameters.length + winch.mean_payout
            expected = out - self._parameters.boom_tip_height + float(self._design["stretch"][0]) * out
            found.append(ALARMS.alarm("PAYOUT_DEPTH_DISAGREE", depth=depth, out=out, expected=expected))
        if happened & Happened.INHIBITED and (alarm := self.guard.note()):
            found += [alarm] if alarm.name != self._alarm_before or not self._was_inhibited else []
            self._alarm_before = alarm.name
        if happened & Happened.LINK_BACK:
            self.modes.resume()
            found.append(ALARMS.alarm("COMMANDS_RESTORED"))
        if happened & Happened.LINK_LOST_OFTEN:
            found.append(ALARMS.alarm("COMMAND_TIMEOUTS"))
        if happened & Happened.TENSION_NOT_KEPT:
            found.append(self._tension_alarm)
        if happened & Happened.AUTHORITY_HELD:
            unknown = SEA_UNKNOWN if tick.is_sea_refuted else GAIN_UNKNOWN if winch.share < 1.0 else ""
            percent, rest = 100.0 * self.guard.authority_limit, 100.0 * self.guard.residual
            cause = unknown or self.guard.cause
            found.append(ALARMS.alarm("AUTHORITY_LIMITED", percent=percent, cause=cause, rest=rest))
        if happened & Happened.AUTHORITY_FREE:
            found.append(ALARMS.alarm("AUTHORITY_RESTORED", percent=100.0 * self.modes.authority))
        return tuple(found)

    @property
    def _load_alarm(self) -> Alarm:
        return ALARMS.alarm("UNIT_NOT_SUSPENDED", percent=100.0 * max(self.landing.share, 0.0))

    @property
    def _tension_alarm(self) -> Alarm:
        needed = math.ceil(100.0 * float(self._state["least_ratio"][0])) / 100.0
        return ALARMS.alarm("TENSION_LIMIT_LOW", needed=needed, limit=float(self._design["highest_ratio"][0]))

    def _peaks_alarm(self) -> tuple[Alarm, ...]:
        """Return that compensation goes on in a sea with peaks above those allowed: at first, and grown by half."""
        peak, share = PEAK_OVER_SIGNIFICANT * self.guard.demand, self.modes.factor * self.guard.authority_limit
        alarm = peaks_alarm(peak, self._parameters.entry.peak_use, share)
        return (alarm,) if alarm else ()

    def _closed_gates(self, tick: LoopTick, winch: WinchSituation) -> str:
        """Return why compensation may not begin in a tick; empty where it may."""
        closed = int(self.done[-2])
        if closed & Gate.LOAD_STANDS:
            return self._load_alarm.brief
        if closed & Gate.LOAD_UNWEIGHED:
            wait = float(self._state["wait"][0])
            return f"averaging the tension for {wait:.0f} s more, to know whether the load hangs"
        if closed & Gate.SEA_UNSEEN:
            wait = float(self._design["longest_wait"][0]) - tick.number * self._dt
            return f"measuring the sea, at most {wait:.0f} s more"
        if closed & Gate.READINGS_DISAGREE:
            return str(tick.inconsistency)
        if closed & Gate.TENSION_LOW:
            return self._tension_alarm.brief
        guard = self.guard
        reasons = [self._range_words(winch)] if closed & Gate.RANGE_SHORT else []
        reasons += [too_much(guard.residual, guard.largest_residual)] if closed & Gate.RESIDUAL_HIGH else []
        return "; ".join(reasons) or winch.proof_gate

    def _why_no_tension(self, tick: LoopTick, winch: WinchSituation) -> str:
        """Return why constant tension may not be asked for in a tick; empty when it may."""
        closed = int(self.done[-1])
        if closed & Gate.LOAD_CELL_LOST:
            return f"the load cell is lost ({lost_sensors(tick, winch)['load_cell']})"
        if closed & (Gate.LOAD_HANGS | Gate.TENSION_UNSEEN):
            out = tick.mean_tension.value - self._load.cable_weight * (
                winch.mean_payout + float(self._design["more"][0])
            )
            share = self._load.weight_share(out) if closed & Gate.LOAD_HANGS else math.nan
            return hanging_words(share, TENSION_MEMORY - tick.mean_tension.time)
        reasons = [self._range_words(winch)] if closed & Gate.RANGE_SHORT else []
        peak = PEAK_OVER_SIGNIFICANT * self.guard.demand
        reasons += [peaks_words(peak, self._parameters.entry.peak_use)] if closed & Gate.PEAKS_HIGH else []
        return "; ".join(reasons)

    def _range_words(self, winch: WinchSituation) -> str:
        return range_words(winch.mean_payout, self._limits, self.guard.tip_sigma)

    def _lowering_alarm(self, tick: LoopTick) -> Alarm:
        """Return that the winch lowers without depth readings in a tick, and how touchdown is known then."""
        is_weighed = math.isfinite(tick.filtered_tension) and "load_cell" not in tick.lost
        ratio = self._parameters.tension.touchdown_ratio
        now = (
            f"Touchdown will be detected by the load cell, below {100.0 * ratio:.0f} % of the weight over "
            f"{self._load.swing_time:.0f} s"
            if is_weighed
            else "Touchdown cannot be detected"
        )
        return ALARMS.alarm("LOWERING_BLIND", now=now)


def lost_sensors(tick: LoopTick, winch: WinchSituation) -> dict[str, str]:
    """Return why each sensor counts as lost in a `tick`, by name: a load cell that has jumped does, for the `winch`."""
    return {"load_cell": "has jumped", **tick.lost} if winch.cell_jumped else tick.lost


def mode_alarm(mode: ModeOutput) -> Alarm:
    """Return the alarm of a change of `mode`: compensation that ends unrequested is one, all else an event."""
    is_lost = mode.before in (Mode.COMPENSATING, Mode.CONSTANT_TENSION) and mode.mode in ENDED
    code = COMPENSATION_LOST if is_lost and not mode.reason.endswith(REQUESTED) else MODE_CHANGED
    return ALARMS.alarm(code, mode=mode.mode.value, reason=mode.reason)


def hanging_load(design: ControllerDesign) -> HangingLoad:
    """Return what landing must know of the load of a design."""
    cable = design.cable
    free_swing = 2.0 * math.pi * math.sqrt(cable.a)
    return HangingLoad(
        design.wet_tension,
        design.unit_weight,
        cable.stiffness,
        following_time=0.25 * free_swing,
        swing_time=max(free_swing, design.parameters.sea.peak_period),
        cable_weight=(design.wet_tension - design.unit_weight) / design.length,
    )


def guarded_loop(design: ControllerDesign, law: ControlLaw) -> GuardedLoop:
    """Return what the guard must know of a design and its law."""
    modes = design.parameters.modes
    return GuardedLoop(
        limits=design.limits,
        effort=law.effort,
        inertia=design.cable.a,
        feeds_back_unit=law.feeds_back_unit,
        keeps_limits=law.keeps_limits,
        fade_time=min(modes.fade_in_time, modes.fade_out_time),
    )


def peaks_words(peak: float, most: float) -> str:
    """Return that the `peak` of the boom tip over the winch's limits is above the `most` that may be used."""
    return f"peaks of the boom tip need {100 * peak:.0f} % of the winch's limits, limit {100 * most:.0f} %"


def peaks_alarm(peak: float, most: float, share: float) -> Alarm | None:
    """Return how the peaks of the boom tip are above what a winch should be used for; None where they are not.

    Compensation need not wait for a lower sea: it begins with what it can have of this one.

    Parameters
    ----------
    peak : of the boom tip over the winch's limits
    most : that may be used
    share : of the sea that compensation begins with
    """
    if not peak > most:
        return None
    rest = "; motion beyond the limits stays" if share * peak > 1.0 else ""
    return ALARMS.alarm("SEA_ABOVE_WINCH", percent=100.0 * peak, limit=100.0 * most, authority=100.0 * share, rest=rest)


def range_words(payout: float, limits: WinchLimits, tip_sigma: float) -> str:
    """Return how the range of a winch with `limits` does not hold the waves about a `payout` [m].

    `tip_sigma` : standard deviation of the boom tip [m]
    """
    room = min(payout - limits.payout_minimum, limits.payout_maximum - payout)
    return (
        f"a payout of {payout:.1f} m leaves {max(room, 0.0):.1f} m to the end of the range, and the sea needs "
        f"{PEAK * tip_sigma:.1f} m"
    )


def hanging_words(share: float, wait: float) -> str:
    """Return why a unit whose landing was missed counts as hanging.

    `share` of its weight the cable carries; NaN: that is not known until a `wait` [s] is over.
    """
    if not math.isnan(share):
        return (
            f"the load is suspended: the cable carries {100.0 * share:.0f} % of its weight, and constant tension "
            "would drop it; land it first, or set tension.hanging"
        )
    return (
        f"averaging the tension for {wait:.0f} s more, to know whether the load is suspended: request it again "
        "then, or set tension.hanging"
    )
