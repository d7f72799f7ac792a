"""Supervision of a tick: the guard's judgement, the mode, and landing, in this order."""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

from heave_core.look import Seen
from heave_node.interface.alarm import Alarm
from heave_node.interface.codes import COMPENSATION_LOST, MODE_CHANGED, REQUESTED

from winch_controller_node.beliefs.beliefs import CAUTIOUS
from winch_controller_node.core.estimation.loop_tick import TENSION_MEMORY, LoopTick, TensionMean, free_swing
from winch_controller_node.core.supervision.command_timeouts import Advice, CommandTimeouts
from winch_controller_node.core.supervision.entry_gates import PEAK_OVER_SIGNIFICANT, EntryGates
from winch_controller_node.core.supervision.guard import HarmGuard
from winch_controller_node.core.supervision.guard_checks import GuardedLoop
from winch_controller_node.core.supervision.landing import LEAST_RATE, HangingLoad, HangingUnit, Landing, LandingEvent
from winch_controller_node.core.supervision.mode_machine import ModeMachine
from winch_controller_node.core.supervision.modes import BRAKED, Mode, ModeOutput, Situation
from winch_controller_node.core.supervision.proofs import Proven
from winch_controller_node.core.supervision.watch.highest_tension import HighestTension
from winch_controller_node.core.supervision.watch.load_watch import Episode
from winch_controller_node.core.supervision.watch.share_news import ShareNews
from winch_controller_node.core.supervision.watch.standing_load import StandingLoad
from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.laws.law import ControlLaw

REQUIRED_SENSORS = {
    Mode.CONSTANT_TENSION: ("load_cell", "encoder"),
    Mode.MANUAL: ("encoder",),
}
"""Sensors without which a mode cannot go on; all others need MRU and encoder."""

ENDED = (*BRAKED, Mode.FADE_OUT, Mode.STOPPING)
"""Modes in which the unit is not held still."""

HANGING_SHARES = (0.7, 1.3)
"""A unit hangs whose cable carries on average a share of its weight between these, and that has not landed."""

LONGEST_AGE = 6.0
"""Age of a depth reading up to which the estimate of its time is kept [s]: the largest latency, 5 s, and a second."""

SEA_UNKNOWN = "boom-tip motion does not match the assumed sea"
GAIN_UNKNOWN = "gain of the winch or scale of the encoder is not known"
"""What keeps authority low before the guard sees errors of it."""

ASK_AGAIN = "check the cause, then request compensation"
"""Ends the reason of an inhibition that only an operator can end."""

SETTLED_AT_REST = 0.01
"""Swing of the unit at which a fade-out may end in calm water [m]; a sea adds its own, up to what a law can settle."""

BLIND_LIMIT = 900.0
"""Longest time for which the unit is damped by the depth sensor alone, until the brake goes on [s]."""

LONGEST_WAIT = 2.0
"""Time until which compensation waits for waves, over `modes.settling_time`: in calm water none come."""


class WinchSituation(NamedTuple):
    """Inputs of supervision about the winch and its commands.

    Attributes
    ----------
    fault : the winch's own, 0 without
    speed : as commanded [m/s], absolute
    mean_payout : that the winch goes to [m]
    settled_swing : swing of the unit at which a fade-out may end [m]
    share : authority that is best with the winch as it is known, above 0
    drum_error : drum less what was predicted of it a second ago [m]
    inhibition : why compensation must be off; None: it need not
    fault_cause : why the winch has its fault, in words; empty: unknown
    is_reversed : drum or encoder are reversed: the winch is brought to rest until an operator releases it
    mean_acceleration : with which the winch goes there [m/s^2]
    envelope : why the envelope has taken over, in words; empty: it has not
    proven : what follows from the proofs
    """

    fault: int
    speed: float
    mean_payout: float
    settled_swing: float
    share: float = 1.0
    drum_error: float = 0.0
    inhibition: Alarm | None = None
    fault_cause: str = ""
    is_reversed: bool = False
    mean_acceleration: float = 0.0
    envelope: str = ""
    proven: Proven = Proven()


class Decision(NamedTuple):
    """What supervision has decided in a tick.

    Attributes
    ----------
    mode : with authority and brake
    is_inhibited : the guard keeps compensation off
    is_damped : the unit is damped while compensation fades out
    trusts_estimate : the depth sensor agrees with the estimate
    fades_by_law : an operator has asked for a fade-out, and all is well: the law itself lets the unit go
    unit_stands : on the bottom
    bounds_tension : the highest tension is one that compensation can keep in this sea
    landing : what has just happened to the unit; None: nothing
    alarms : raised in this tick
    """

    mode: ModeOutput
    is_inhibited: bool
    is_damped: bool
    trusts_estimate: bool
    fades_by_law: bool
    unit_stands: bool
    bounds_tension: bool
    landing: LandingEvent | None
    alarms: tuple[Alarm, ...]


class Supervisor:
    """Decides what the controller does.

    Parameters
    ----------
    design : the active one; law : of it

    Attributes
    ----------
    modes : for requests of the operator
    guard : whether compensation is harmful
    landing : whether the unit stands
    timeouts : whether compensation goes on after a command timeout of the winch
    highest_tension : whether it is one that compensation can keep
    """

    def __init__(self, design: ControllerDesign, law: ControlLaw) -> None:
        parameters, dt = design.parameters, design.tick_period
        self.modes = ModeMachine(
            parameters.modes, moves_winch=law.moves_winch, factor=parameters.factor, tick_period=dt
        )
        self.guard = HarmGuard(parameters.guard, guarded_loop(design, law), tick_period=dt)
        self.landing = Landing(parameters.tension, hanging_load(design))
        self._standing = StandingLoad(self.landing, design)
        self.timeouts = CommandTimeouts(dt, resumes=parameters.modes.resume, count=self.guard.interrupt)
        self._code_before = ""
        self._fades_by_law = False
        self._share_news = ShareNews(dt)
        self._blind_time = 0.0
        self._blind_lowering = Episode(dt)
        self._dt = dt
        self._unit_past: deque[float] = deque(maxlen=1 + round(LONGEST_AGE / dt))
        self._refer_to(design)
        self._watch_sea()

    def take_design(self, design: ControllerDesign, law: ControlLaw) -> None:
        """Supervise another design and its law from now on."""
        self.guard.take_loop(guarded_loop(design, law))
        self.landing.take_load(hanging_load(design))
        self._standing.take_design(design)
        self._refer_to(design)

    def reset_sea(self) -> None:
        """Look at the sea again: what was seen until now was another one."""
        self.guard.reset_sea()
        self._watch_sea()

    def _watch_sea(self) -> None:
        """Begin to watch it."""
        self._gates = EntryGates(self._parameters.entry)
        self.highest_tension = HighestTension(self._parameters.guard.window, tick_period=self._dt)

    def _refer_to(self, design: ControllerDesign) -> None:
        self._parameters, self._inertia = design.parameters, design.cable.a
        self._load, self._limits = hanging_load(design), design.limits

    def decide(self, tick: LoopTick, winch: WinchSituation) -> Decision:
        """Return what is to be done in a tick with the `winch` in this situation."""
        time = tick.number * self._dt
        # where the drum is, not where its command is
        hanging = HangingUnit(-tick.hanging_heave, tick.hanging_stretch)
        self.landing.observe(time, tick, tick.mean_payout, hanging)
        if winch.inhibition:
            self.guard.inhibit(winch.inhibition)
        modes = self.modes
        alarms = self._standing.update(
            tick, winch.mean_payout, self._load, brake=modes.brake, is_wanted=modes.wants_compensation
        )
        alarms += self._judge(tick, winch) + self._resume_after_timeout(tick, winch)
        self._gates.observe(self.guard.tip_sigma)
        alarms += self._watch_highest_tension(tick)
        lost = self._lost(tick)
        alarms += self._report_share(tick, winch)
        authority_limit = self.guard.authority_limit
        is_damped_blind = self._watch_blind_damping(tick, winch.settled_swing)
        # a unit that stands is at rest, and one that swings as below a locked winch may go beyond a highest tension
        can_settle = not self.landing.unit_stands and math.isinf(self._limits.maximum_tension)
        settles = self._fades_by_law and can_settle
        has_faded = settles and self.modes.authority == 0.0
        is_damped = not winch.is_reversed and (is_damped_blind or has_faded or self._may_damp(tick, lost))
        is_settled = not (is_damped or settles) or self._is_settled(tick, winch.settled_swing)
        mode = self.modes.step(
            self._situation(tick, winch, lost, authority_limit, is_settled=is_settled, is_damped_blind=is_damped_blind)
        )
        if mode.before is not None:
            alarms += (mode_alarm(mode),)
            alarms += self._report_peaks(mode, authority_limit)
        if mode.mode is Mode.COMPENSATING and mode.before is Mode.FADE_OUT:
            self.guard.allow_resumption()
        if mode.mode is not Mode.FADE_OUT or lost:
            self._fades_by_law = False
        elif mode.before is Mode.COMPENSATING:
            self._fades_by_law = not self.modes.wants_compensation
        alarms += self._report_blind_lowering(tick, mode)
        landing = self._watch_landing(tick, mode)
        return Decision(
            mode=mode,
            is_inhibited=self.guard.inhibits,
            is_damped=is_damped,
            trusts_estimate=self.guard.trusts_estimate and not winch.is_reversed,
            fades_by_law=self._fades_by_law,
            unit_stands=not self.landing.hangs,
            bounds_tension=self.highest_tension.is_kept,
            landing=landing,
            alarms=alarms,
        )

    def _situation(
        self,
        tick: LoopTick,
        winch: WinchSituation,
        lost: str,
        authority_limit: float,
        *,
        is_settled: bool,
        is_damped_blind: bool,
    ) -> Situation:
        """Return what `winch`, guard, gates and the sensors that are `lost` tell the modes in a tick.

        `authority_limit`, `is_settled` and `is_damped_blind` are the fields of that name.
        """
        is_reversed = winch.is_reversed
        return Situation(
            authority_limit=authority_limit,
            is_settled=is_settled,
            is_damped_blind=is_damped_blind,
            shown_authority=self.guard.shown_authority,
            has_estimate=tick.has_encoder,
            winch_fault=winch.fault,
            fault_cause=winch.fault_cause,
            lost=lost,
            harm=f"{self.guard.reason}; {ASK_AGAIN}" if is_reversed else self.guard.reason,
            prospect="" if is_reversed else self.guard.prospect,
            awaits_operator=is_reversed or self.guard.awaits_operator,
            resumes_after_fault=self.timeouts.is_pending,
            speed=winch.speed,
            envelope=winch.envelope,
            gates=lambda: self._closed_gates(tick, winch.mean_payout) or winch.proven.gate,
            tension=lambda: self._why_no_tension(tick, winch.mean_payout),
        )

    def _resume_after_timeout(self, tick: LoopTick, winch: WinchSituation) -> tuple[Alarm, ...]:
        """Ask for compensation again where only late commands ended it; return what is to be reported."""
        wants_compensation = self.modes.wants_compensation
        is_stopped = self.modes.mode is Mode.STOPPED
        is_well = is_stopped and not self._lost(tick) and (self.modes.may_resume or not wants_compensation)
        # also the link must be: the report is that commands reach the winch again
        is_well = is_well and not winch.inhibition
        advice = self.timeouts.update(
            winch.fault, wants_compensation=wants_compensation, is_stopped=is_stopped, is_well=is_well
        )
        if advice is Advice.RESUME:
            self.modes.request(Mode.COMPENSATING.value)
        return (advice.alarm,) if advice else ()

    def _judge(self, tick: LoopTick, winch: WinchSituation) -> tuple[Alarm, ...]:
        """Have the guard judge the tick, with the `winch` in this situation; return its new alarm."""
        # the estimate is that of a hanging unit
        hangs = self.landing.hangs and not self.landing.may_stand
        is_judged = hangs and tick.knows_tip and self.modes.mode is not Mode.CONSTANT_TENSION
        depth_now = self._depth_now(tick)
        seen = Seen(
            tick.unit,
            tick.unit_rate,
            # as the unit is counted: with a winch that does nothing but move the mean payout
            tick.free + tick.mean_heave,
            tick.free_rate + tick.mean_rate,
            tick.tip,
            tick.tip_rate,
            tick.payout_rate,
            depth_now if hangs else math.nan,
            tick.depth_noise,
            winch.mean_acceleration,
            winch.drum_error,
            _unknown(tick, winch),
            tick.payout,
        )
        fades = self.modes.mode in (Mode.FADE_OUT, Mode.STOPPING)
        self.guard.update(seen, self.modes.authority if is_judged else 0.0, self.modes.target, fades=fades)
        alarm, before = self.guard.alarm, self._code_before
        self._code_before = "" if alarm is None else alarm.code
        return (alarm,) if alarm is not None and alarm.code != before else ()

    def _depth_now(self, tick: LoopTick) -> float:
        """Return the unit's heave by the newest depth reading, carried from its stamp to now by the estimate [m].

        A sensor that is late, or slow, reads where the unit was. NaN: no reading came.
        """
        unit, past = tick.unit - tick.mean_heave, self._unit_past
        past.appendleft(unit)
        if math.isnan(tick.depth_heave):
            return math.nan
        age = tick.number * self._dt - tick.depths[-1][0] if tick.depths else 0.0
        then = past[min(max(round(age / self._dt), 0), len(past) - 1)]
        return float(tick.depth_heave + tick.mean_heave + unit - then)

    def _report_share(self, tick: LoopTick, winch: WinchSituation) -> tuple[Alarm, ...]:
        """Return what limits authority, where it lasts, or that it is over."""
        guard, cause = self.guard, ""
        if guard.is_reduced:
            cause = SEA_UNKNOWN if tick.is_sea_refuted else GAIN_UNKNOWN if winch.share < 1.0 else guard.cause
        alarm = self._share_news.update(
            guard.authority_limit if cause else 1.0,
            cause,
            residual=guard.residual,
            authority=self.modes.authority,
            factor=self.modes.factor,
            compensates=self.modes.mode is Mode.COMPENSATING,
        )
        return (alarm,) if alarm else ()

    def _report_peaks(self, mode: ModeOutput, authority_limit: float) -> tuple[Alarm, ...]:
        """Return that compensation begins in a sea whose peaks are beyond what the winch should be used for.

        Parameters
        ----------
        mode : of the tick
        authority_limit : largest authority allowed
        """
        if mode.mode is not Mode.COMPENSATING or mode.before is not Mode.STANDBY:
            return ()
        alarm = self._gates.peaks_alarm(self.guard.demand, self.modes.factor * authority_limit)
        return (alarm,) if alarm else ()

    def _closed_gates(self, tick: LoopTick, mean_payout: float) -> str:
        """Return why compensation may not begin about a mean payout [m]; empty where it may."""
        if gate := self._standing.gate:
            return gate
        wait = LONGEST_WAIT * self._parameters.modes.settling_time - tick.number * self._dt
        if not tick.knows_sea and wait > 0.0:
            return f"measuring the sea, at most {wait:.0f} s more"
        if tick.inconsistency:
            return str(tick.inconsistency)
        if self.highest_tension.alarm:
            return self.highest_tension.alarm.brief
        residual, most = self.guard.residual, self.guard.largest_residual
        return self._gates.for_compensation(mean_payout, self._limits, residual, most)

    def _watch_highest_tension(self, tick: LoopTick) -> tuple[Alarm, ...]:
        """Return that the sea has become too high for the highest tension, where that is new."""
        if math.isinf(self._limits.maximum_tension):
            return ()
        load, highest = self._load, self.highest_tension
        was_kept = highest.is_kept
        highest.update(
            tick.tip - tick.free,
            self._limits.maximum_tension / load.static_tension,
            tension_per_metre=load.stiffness / load.static_tension,
            peak_use=PEAK_OVER_SIGNIFICANT * self.guard.demand,
            brake=self.modes.brake,
        )
        if highest.is_kept or not was_kept or self.modes.mode is not Mode.COMPENSATING:
            return ()
        return (highest.alarm,) if highest.alarm else ()

    def _lost(self, tick: LoopTick) -> str:
        """Return which of the required sensors are lost and why; empty when none."""
        lost = tick.lost
        if not lost:
            return ""
        required = REQUIRED_SENSORS.get(self.modes.mode, ("mru", "encoder"))
        return ", ".join(f"{name} {lost[name]}" for name in required if name in lost)

    def _why_no_tension(self, tick: LoopTick, payout: float) -> str:
        """Return why constant tension may not be asked for; empty when it may."""
        if "load_cell" in tick.lost:
            return f"the load cell is lost ({tick.lost['load_cell']})"
        if self.modes.mode is Mode.CONSTANT_TENSION:
            return ""  # the winch follows already
        may_hang = self._parameters.tension.hanging or not self.landing.hangs
        if not may_hang and (hangs := self._may_hang(tick.mean_tension, payout)):
            return hangs
        return self._gates.for_tension(payout, self._limits, self.guard.demand)

    def _may_hang(self, tension: TensionMean, payout: float) -> str:
        """Return why a unit whose landing was missed counts as hanging; empty: it stands.

        `tension` is the mean at a mean `payout` [m].
        """
        share, error = self._load.mean_share(tension, payout + self._standing.more)
        least, most = HANGING_SHARES
        if least - error < share < most + error:
            return (
                f"the load is suspended: the cable carries {100.0 * share:.0f} % of its weight, and constant tension "
                "would drop it; land it first, or set tension.hanging"
            )
        wait = TENSION_MEMORY - tension.time
        if wait > 0.0:
            return (
                f"averaging the tension for {wait:.0f} s more, to know whether the load is suspended: request it again "
                "then, or set tension.hanging"
            )
        return ""

    def _may_damp(self, tick: LoopTick, lost: str) -> bool:
        """Tell whether the unit is to be damped in a fade-out: after harm, or without the encoder (`lost`).

        For that time payout is known from the commands sent, and the rest from MRU and depth sensor.
        """
        is_known = tick.has_depth and "depth" not in tick.lost and "mru" not in lost
        return self.guard.trusts_estimate and (self.guard.inhibits if not lost else is_known)

    def _is_settled(self, tick: LoopTick, settled_swing: float) -> bool:
        """Tell whether the unit swings no more about its uncompensated motion: the winch may stop.

        In calm water it is hardly to move at all, and rests below where the drum stands when it stops.
        """
        if math.isinf(settled_swing):
            return True
        if tick.knows_tip:
            released = free_swing(tick.released, tick.released_rate, self._inertia)
            settled_swing = min(settled_swing, SETTLED_AT_REST + released)
        return free_swing(tick.offset, tick.offset_rate, self._inertia) < settled_swing

    def _watch_blind_damping(self, tick: LoopTick, settled_swing: float) -> bool:
        """Count for how long a fade-out has damped the unit by the depth sensor alone; return whether it does and may.

        Let go at rest the unit would take minutes to swing as it does without compensation, and swing more on the way.
        """
        has_depth = tick.has_depth and "depth" not in tick.lost and self.guard.trusts_estimate
        is_blind = not tick.knows_tip and has_depth and math.isfinite(settled_swing)
        self._blind_time = self._blind_time + self._dt if is_blind else 0.0
        return is_blind and self._blind_time < BLIND_LIMIT

    def _report_blind_lowering(self, tick: LoopTick, mode: ModeOutput) -> tuple[Alarm, ...]:
        """Return that the winch lowers without depth readings, and how touchdown is known then, where that is new."""
        is_blind = mode.mode is Mode.COMPENSATING and not tick.sees_landing and not self.landing.unit_stands
        if not self._blind_lowering.begins(is_blind and self.landing.lowering_rate >= LEAST_RATE):
            return ()
        is_weighed = math.isfinite(tick.filtered_tension) and "load_cell" not in tick.lost
        ratio = self._parameters.tension.touchdown_ratio
        now = (
            f"Touchdown will be detected by the load cell, below {100.0 * ratio:.0f} % of the weight over "
            f"{self._load.swing_time:.0f} s"
            if is_weighed
            else "Touchdown cannot be detected"
        )
        return (ALARMS.alarm("LOWERING_BLIND", now=now),)

    def _watch_landing(self, tick: LoopTick, mode: ModeOutput) -> LandingEvent | None:
        """Notice touchdown while lowering, and that the unit hangs again after lift-off."""
        if not math.isfinite(tick.filtered_tension):
            return None
        return self.landing.update(tick, mode)


def _unknown(tick: LoopTick, winch: WinchSituation) -> float:
    """Return the variance that what is not known of sea and `winch` leaves of compensated motion, over that motion's.

    That of an authority A which is best is 1/A - 1.
    """
    return 1.0 / winch.share - 1.0 + (1.0 / CAUTIOUS - 1.0 if tick.is_sea_refuted else 0.0)


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
