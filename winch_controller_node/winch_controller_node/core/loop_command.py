"""From mode and loop to the order: which law is asked, the mean payout's share, the governor, the set-points.

All of it is made in the core (act.cpp); a law of somebody else and a plan at the limits are asked here.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from heave_core.law import Acting, Commander, Place, put
from heave_core.law_table import COMMAND, COMMAND_STATE, Asks, Shaped, Way
from heave_core.library import new
from heave_node.interface.preview import HeavePreview

from winch_controller_node.core.envelope import OrderEnvelope
from winch_controller_node.core.estimation.loop_tick import MOTIONS_IN_TICK, CommandShares, LoopTick
from winch_controller_node.core.estimation.observation import EncoderGate
from winch_controller_node.core.supervision.modes import SETTLING_LIMIT, Mode
from winch_controller_node.core.supervision.rolling_kpi import KpiWindow
from winch_controller_node.core.supervision.supervisor import Decision
from winch_controller_node.core.supervision.watch.load_watch import LoadWatch
from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.laws.constant_tension import TRAVEL, ConstantTension
from winch_controller_node.laws.core_law import CoreLaw
from winch_controller_node.laws.law import ControlLaw, LawCommand
from winch_controller_node.laws.outlet_hold import OutletHold
from winch_controller_node.laws.parts.governor import TENSION, GovernedCommand, drum_ahead, shaped_by
from winch_controller_node.laws.parts.loop_state import LoopState, Reference
from winch_controller_node.laws.parts.winch_limits import ActiveWinch, WinchLimits
from winch_controller_node.model.models import loop_rows
from winch_controller_node.motion.mean_motion import MeanMotion

GIVING_TIME = 1.0
"""A winch gives way to a tension above the highest one within this time [s], and no quicker than twice its lag."""

COUNT_MARGIN = 0.2
"""Time that an order may take longer than the nominal delay to the drive's position loop [s]: some ticks."""

EASING = 2.0
"""Time after a change of what is assumed in which the order makes no larger step [s]."""

CONSTANTS = {
    "largest_unseen": 0.02,
    "unseen_error": 0.5,
    "minute": 60.0,  # some waves
    "more_travel": 1.2,
    "more_room": 0.1,
    "quicker": 1.5,
    "more_acceleration": 0.3,
}
"""Constants of the command: meanings and units are in the core's table, COMMAND_DESIGN."""

WAYS = {
    Mode.COMPENSATING: Way.BY_LAW,
    Mode.CONSTANT_TENSION: Way.BY_TENSION,
    Mode.MANUAL: Way.BY_PLACE,
    Mode.STOPPING: Way.BY_SLOWING,
}
"""By what the command is made in a mode without its brake."""

ASKED, VALUE, STANDING, COMPENSATING, MEAN = (
    [row.name for row in COMMAND.rows].index(name) for name in ("asked", "value", "standing", "compensating", "mean")
)
"""Places in the core's command."""

LEAK = 60.0
"""Time constant with which the place of a speed is drawn to the drum [s]: far slower than the waves."""

REACH = 2.0
"""Furthest that it leads the drum [m]: one second at the largest speed of a winch."""

ENVELOPE, BY_ENVELOPE = "envelope", Shaped.BY_ENVELOPE | Shaped.BY_BOUNDS
"""Name of the bound on what leaves, and its bits: an order that it has replaced, or that was kept within it."""


def commander(
    design: ControllerDesign, winch: ActiveWinch, law: ControlLaw, state: Any, command: Any = None
) -> Commander:
    """Return the command of the core for a `design`, its active `winch` and its `law`.

    `state` is what it remembers, `command` an array of one `Command` that it makes; None: its own.
    """
    model, modes, rows, assumed = design.model, design.parameters.modes, loop_rows(design.model), winch.winch
    core = Commander(winch.record, model.order, law.core if isinstance(law, CoreLaw) else None, state, command)
    payout_ahead, rate_ahead = drum_ahead(model, assumed)
    values = {
        "payout": model.state("payout"),
        "unit": rows.unit_states,
        "sea_states": len(design.sea_states),
        "sea": [model.state(name) for name in design.sea_states],
        "payout_row": rows.payout,
        "payout_ahead": payout_ahead,
        "rate_ahead": rate_ahead,
        "inertia": design.cable.a,
        "stiffness": design.cable.stiffness,
        "giving_time": max(GIVING_TIME, 2.0 * (assumed.command_delay + assumed.time_constant)),
        "stop_step": modes.stop_deceleration * design.tick_period,
        "longest_fade": modes.fade_out_time + SETTLING_LIMIT,
        **CONSTANTS,
    }
    if assumed.law == "speed_servo":
        values["fade"] = OutletHold(model, assumed, 0.0).row
        values["settling"] = OutletHold(model, assumed, design.cable.a).row
    put(core.design, values)
    return core


class TickCommand(NamedTuple):
    """The command of a tick, in the terms of the model."""

    asked: LawCommand  # by the law, without the mean payout's share
    governed: GovernedCommand  # what left in the end, the mean payout's share included
    standing: float  # command under which the winch would stay where it is, in its unit


class Beside(NamedTuple):
    """What else the acting half of a tick works on."""

    motion: MeanMotion  # mean payout
    envelope: OrderEnvelope  # in front of the winch
    kpi: KpiWindow  # window of the figures of merit
    load: LoadWatch  # alarms of load and winch


class Tick(NamedTuple):
    """What a tick goes by."""

    loop: LoopTick  # what is known of it
    decision: Decision  # what is to be done
    static_tension: float  # under the hanging unit at rest [N]
    is_at_limit: bool  # a limit of the winch that a sea takes it to acts
    stated_payout: float  # payout that was read before it is known to be the mean one [m]; NaN: it is known
    encoder: EncoderGate  # that counts


class LoopCommand:
    """The acting half of a tick, in the core: from what is to be done to the order that leaves.

    Parameters
    ----------
    design : the active one; law : of it, for compensation
    beside : what else it works on
    """

    def __init__(self, design: ControllerDesign, law: ControlLaw, beside: Beside) -> None:
        self._state, self._command = new(COMMAND_STATE), new(COMMAND)
        self._numbers = self._command.view(np.float64)
        self._elsewhere: LawCommand | None = None
        self._beside, self._acting = beside, Acting()
        place = Place(LEAK, REACH).record
        others = {**beside.envelope.records, **beside.kpi.records, **beside.load.records}
        self._acting.take(motion=beside.motion.record, place=place, **others)
        self._tension = ConstantTension(self._state["tension"])
        self.take_design(design, law)

    def take_design(self, design: ControllerDesign, law: ControlLaw) -> None:
        """Use a design and its `law` from now on; the tension that is held stays."""
        parameters, model = design.parameters, design.model
        self._winch = parameters.winch
        self._law = law
        # of a law of the suite the command shares the winch: limits have one place
        active = law.winch if isinstance(law, CoreLaw) else ActiveWinch(self._winch, design.limits, design.tick_period)
        active.take(self._winch, design.limits)
        self._core_law = law if isinstance(law, CoreLaw) else None
        self._active = active
        damping = None if self._is_first_order else OutletHold(model, self._winch, design.cable.a)
        self._settled_swing = math.inf if damping is None else damping.settled_swing
        self._core = commander(design, active, law, self._state, self._command)
        self._acting.take(**self._core.records, A=np.ascontiguousarray(model.A), B=model.B[:, 0].copy())
        self._beside.kpi.take_winch(self._winch)
        tension = self._tension.take_design(
            model, design.cable, self._winch, parameters.tension, round_trip=design.wave_round_trip
        )
        put(self._core.design["tension"], tension)

    @property
    def _is_first_order(self) -> bool:
        return self._winch.law == "first_order"

    @property
    def time_of_another_count(self) -> float:
        """Time from a jump of the encoder to the first effect of an order that is in its new count [s].

        Meanwhile a position loop goes by the old order in the new count. Without one there is no such time.
        """
        has_loop = self._is_first_order or self._winch.position_gain > 0.0
        return self._winch.command_delay + COUNT_MARGIN if has_loop else 0.0

    @property
    def settled_swing(self) -> float:
        """Swing of the unit at which a fade-out may end [m]; infinite where the law is not asked to damp it."""
        return self._settled_swing

    def ease(self) -> None:
        """Let the order make no step for some seconds: something else is assumed."""
        put(self._state, {"easing": EASING})

    def begin_tension(self, measured: float) -> None:
        """Begin constant tension at the measured tension [N]."""
        self._tension.begin(measured)

    def hold_tension(self, tension: float) -> None:
        """Go to another tension [N] from the one that is held."""
        self._tension.hold(tension)

    @property
    def shares(self) -> CommandShares:
        """What was commanded last: what compensates, and what moves the mean payout."""
        return CommandShares(self._numbers.item(COMPENSATING), self._numbers.item(MEAN))

    def speed(self, tick: LoopTick) -> float:
        """Return the speed of the winch as last commanded at `tick` [m/s], absolute."""
        numbers = self._numbers
        if self._is_first_order:
            return math.fabs(tick.total_payout_rate)
        speed: float = numbers.item(VALUE) - numbers.item(STANDING)
        return abs(speed)

    @property
    def limits(self) -> WinchLimits:
        """The active limits of the winch."""
        return self._active.limits

    def payout_range(self) -> tuple[float, float]:
        """Return the ends of the range that the mean payout may use [m]."""
        limits = self.limits
        return limits.payout_minimum, limits.payout_maximum

    def act(self, tick: Tick, preview: HeavePreview | None = None) -> None:
        """Make command and set-points of a `tick`: the law's and the mean payout's share, governed.

        `preview` : of the boom tip, seen from this tick; None: there is none
        """
        core, law, acting, loop = self._core, self._core_law, self._acting, tick.loop
        core.estimate[:], core.mean_state[:], acting.motions[:] = loop.estimate, loop.mean_state, loop[MOTIONS_IN_TICK]
        acting.seen[:] = self._seen(tick)
        if preview is not None:
            preview = replace(preview, heave=tick.decision.mode.authority * preview.heave)
        if law is not None and law.preview is None:
            asks = acting.act()
        else:
            acting.pose()
            if law is not None and law.planner is not None:
                law.planner.see(preview, core.x)
            asks = acting.answer()
        if asks == Asks.NEEDS_TENSION:
            self._tension.begin_alone(self._payout())
            asks = acting.answer()
        self._elsewhere = self._asked_elsewhere(asks, preview) if asks else None
        if self._elsewhere is not None:
            self._numbers[ASKED] = self._elsewhere.value
            acting.make()

    def leave(self) -> list[float]:
        """Send the order through the envelope; all go by what is sent. Return what has been done, as in ACT_DONE."""
        self._acting.leave()
        done: list[float] = self._acting.done.tolist()
        return done

    def _seen(self, tick: Tick) -> tuple[float, ...]:
        """Return what is to be done in a tick and what was read in it, in the order of `ActSeen`."""
        loop, decision, encoder = tick.loop, tick.decision, tick.encoder
        mode = decision.mode
        return (
            *(self._way(decision), mode.authority, mode.mode is Mode.COMPENSATING, mode.mode is Mode.FADE_OUT),
            *(mode.brake, decision.is_damped, decision.bounds_tension, decision.unit_stands),
            *(loop.knows_tip, loop.has_depth, loop.sees_landing, "mru" not in loop.lost, loop.mru_rate),
            *(loop.tension, loop.filtered_tension, tick.static_tension, tick.is_at_limit, tick.stated_payout),
            *(encoder.scale, encoder.offset),
        )

    def _way(self, decision: Decision) -> Way:
        """Return by what the command of a tick is made."""
        if decision.mode.brake:
            return Way.BY_BRAKE
        if decision.mode.mode is not Mode.FADE_OUT:
            return WAYS.get(decision.mode.mode, Way.BY_NOTHING)
        if not decision.trusts_estimate:
            return Way.BY_SLOWING
        if self._is_first_order:  # it has no rate to command: its law fades out by itself
            return Way.BY_LAW
        if decision.is_damped:
            return Way.BY_SETTLING
        # where a sensor was lost the estimated motion of the unit is not to be acted upon
        return Way.BY_LAW if decision.fades_by_law else Way.BY_FADE

    def _asked_elsewhere(self, asks: int, preview: HeavePreview | None) -> LawCommand:
        """Return what the core `asks` for: a plan, or another law."""
        if asks & Asks.NEEDS_PLAN:
            assert self._core_law is not None
            return self._core_law.planned()
        return self._law.command(self._posed(preview))

    def _payout(self) -> float:
        """Return the payout of the drum [m]."""
        core, row = self._core, self._core.design["payout_row"][0]
        return float(row[: len(core.x)] @ core.x) + float(core.problem["payout"][0])

    def _posed(self, preview: HeavePreview | None) -> LoopState:
        """Return the problem of the tick as a law is given it, with the `preview` of its authority."""
        problem = self._core.problem[0]
        payout, rate, command, static, measured, mru_rate, bounds_tension = problem.item()[:7]
        reference = Reference(payout, rate, command)
        x = np.array(self._core.x)
        return LoopState(x, reference, static, measured, mru_rate, preview, bounds_tension=bool(bounds_tension))

    @property
    def last(self) -> TickCommand:
        """The command of the last tick."""
        made = self._core.made
        if self._elsewhere is not None:
            law = self._elsewhere._replace(value=made.asked)
        elif self._core_law is None:
            law = LawCommand(made.asked)
        else:
            law = self._core_law.commanded(made.asked, by_plan=made.by_plan, has_plan=made.has_plan)
        if made.at_travel:
            law = law._replace(active=(TRAVEL,))
        if made.gives_way:
            law = law._replace(active=(*law.active, TENSION))
        shaped = int(made.shaped)
        active = shaped_by(shaped & ~BY_ENVELOPE, is_first_order=self._is_first_order)
        active += (ENVELOPE,) if shaped & BY_ENVELOPE else ()
        return TickCommand(law, GovernedCommand(made.value, active, made.sent), made.standing)
