"""From what a record shows to answers: each loop that is asked for, with its bands."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from heave_node.kpi import significant

from heave_bringup.errors import CommandError
from heave_bringup.whatif.answer import Figures, Spread, figures, unit_motion, with_bands
from heave_bringup.whatif.known import OFF, Known, Show, off_sigma, quiet, show_some
from heave_bringup.whatif.signals.record import shortened
from heave_bringup.whatif.twin.plant import driven
from heave_bringup.whatif.twin.replay import Asked, Past, Replayed, replay
from heave_bringup.whatif.twin.winch import tension_at_ticks
from heave_bringup.workers.pool import worker_pool


@dataclass(frozen=True)
class Answer:
    """What one loop would have done.

    Attributes
    ----------
    asked : for it
    figures : with their bands
    done : motions
    fade_out : probability that it gives up compensation [-]
    cause : the alarm with which it does; empty: it does not
    """

    asked: Asked
    figures: Figures
    done: Replayed = field(repr=False)
    fade_out: float
    cause: str


def answers(
    known: Known,
    wanted: Sequence[Asked],
    others: Sequence[Known] = (),
    plants: Sequence[Known] = (),
    *,
    processes: int = 1,
    show: Show = quiet,
) -> list[Answer]:
    """Return what the loops that are asked for would have done.

    Parameters
    ----------
    known : by the record
    wanted : controllers and winches
    others : draws of what the record allows, over which each loop is closed again, for the bands
    plants : draws of cable, unit and MRU, on which its payout is tried
    processes : that close loops at a time
    show : called with what is done, and the share of it
    """
    parts = [one.part(known.enough) for one in others]
    tasks = [(one, asked) for asked in wanted for one in (known, *parts)]
    seen = [_seen(one, asked) if one is known or _is_off(asked) else None for one, asked in tasks]
    open_ = [(one.past, asked) for (one, asked), done in zip(tasks, seen, strict=True) if done is None]
    closed = iter(_closed(open_, processes, show))
    done = [next(closed) if one is None else one for one in seen]
    count = 1 + len(parts)
    return [
        _answer(known, asked, done[count * number : count * (number + 1)], parts, plants)
        for number, asked in enumerate(wanted)
    ]


def _is_off(asked: Asked) -> bool:
    """Return whether what is asked for is no loop: the winch is locked."""
    return asked.controller.law == OFF


def _seen(known: Known, asked: Asked) -> Replayed | None:
    """Return what is asked for where what is `known` has it already: the winch locked, or the record itself."""
    if _is_off(asked):
        return known.off
    is_own = asked.controller == known.nominal and asked.winch is None
    return _as_recorded(known) if is_own and known.again.is_same else None


def _closed(tasks: Sequence[tuple[Past, Asked]], processes: int, show: Show) -> list[Replayed]:
    """Return what each loop does over its past, closed in so many `processes`."""
    before = np.cumsum([0, *(past.record.ticks for past, _ in tasks)]).tolist()
    if processes == 1 or len(tasks) <= 1:
        return [
            replay(past, asked, on_tick=partial(_show_of, show, asked.name, start, before[-1]))
            for (past, asked), start in zip(tasks, before, strict=False)
        ]
    try:
        with worker_pool(min(processes, len(tasks))) as pool:
            coming = {pool.submit(replay, past, asked): past.record.ticks for past, asked in tasks}
            done = 0
            for future in as_completed(coming):
                done += coming[future]
                show("closing loops", done / before[-1])
            return [future.result() for future in coming]
    except BrokenProcessPool as error:
        raise CommandError("a process ended without a result: it was killed, or out of memory") from error


def _answer(
    known: Known, asked: Asked, loops: Sequence[Replayed], parts: Sequence[Known], plants: Sequence[Known]
) -> Answer:
    """Return what a loop would have done by its `loops`: over what is `known`, then over `parts` that are drawn."""
    done, *drawn = loops
    base = _figures(known, done)
    early = _figures(known.part(known.enough), shortened(done, len(done.time), known.enough))
    draws = [_figures(one, what) for one, what in zip(parts, drawn, strict=True)]
    past, window = known.past, known.window
    spread = Spread(
        loops=[one.beside(early) for one in draws],
        plants=[_figures(one, _on_plant(one, asked, done)).beside(base) for one in plants],
        added=float(np.std((done.unit + done.set_point - past.moved.unit - known.set_point)[window])),
        locked=float(np.std((known.off.unit - past.moved.unit)[window])),
        model=known.model,
    )
    found = with_bands(base, spread, off_sigma(known), known.by_tip)
    if _is_off(asked):
        # it is the reference of the efficiency
        found = replace(found, bands={**found.bands, "unit_efficiency": (0.0, 0.0)})
    lost = [one for one in (base, *draws) if math.isfinite(one.lost_at)]
    return Answer(asked, found, done, len(lost) / len(loops), lost[0].cause if lost else "")


def _on_plant(known: Known, asked: Asked, done: Replayed) -> Replayed:
    """Return what a loop has `done`, with the motions of the plant that is `known`."""
    if _is_off(asked):
        return known.off
    past = known.past
    motion = driven(past.line, past.length, past.tip, done.payout, done.rate, tick_period=past.record.tick_period)
    return replace(done, unit=motion.unit, tension=motion.tension)


def _figures(known: Known, done: Replayed) -> Figures:
    record = known.past.record
    read = tension_at_ticks(record)
    tension = read + done.tension - known.past.moved.tension if np.isfinite(read).any() else done.tension
    unexplained = known.unexplained_in(done.payout)
    unit = unit_motion(done, unexplained)
    return figures(
        done,
        unit,
        np.maximum(np.where(np.isfinite(tension), tension, done.tension), 0.0),
        sigma=known.sigma(unit, unexplained),
        window=known.window,
        uncompensated=off_sigma(known),
        tick_period=record.tick_period,
    )


def _show_of(show: Show, words: str, before: int, of: int, done: int) -> None:
    """Show how far a part of the work is, `before` which so much was done."""
    show_some(show, words, before + done, of)


def recorded(known: Known, found: Sequence[Answer] = ()) -> Figures:
    """Return the figures of the record itself, by what is `known` of it.

    They have bands where the winch locked is among the answers that were `found`: of the unit from what the depth
    sensor shows alone to that and all that is not known of the boom tip; of the efficiency, with those of the locked
    winch.
    """
    figures, off = _figures(known, _as_recorded(known)), next((one for one in found if _is_off(one.asked)), None)
    if off is None:
        return figures
    low, high = known.sigma_ends(known.past.plant.unit + known.set_point + known.unexplained.heave)
    sigma, value = figures.values["unit_sigma_m"], figures.values["unit_efficiency"]
    free, (free_low, free_high) = off.figures.values["unit_sigma_m"], off.figures.bands["unit_sigma_m"]
    # each end by both errors, which have nothing to do with one another
    ends = (
        value - math.hypot(high - sigma, sigma * (free / max(free_low, 1e-9) - 1.0)) / free,
        value + math.hypot(sigma - low, sigma * (1.0 - free / max(free_high, 1e-9))) / free,
    )
    bands = {"unit_sigma_m": (low, high), "significant_residual_m": (significant(low), significant(high))}
    return replace(figures, bands={**bands, "unit_efficiency": ends})


def _as_recorded(known: Known) -> Replayed:
    """Return what the loop of the record did: its orders given again give its payout and readings to the last bit."""
    past, record = known.past, known.past.record
    return replace(
        known.off,
        payout=past.winch.payout,
        rate=past.winch.rate,
        unit=past.plant.unit,
        tension=past.plant.tension,
        modes=record.modes,
        alarms=known.again.alarms,
        limits_hit=record.limits_hit,
        refused=known.again.refused,
    )


def same_again(known: Known, *, show: Show = quiet) -> tuple[float, float]:
    """Return the error of payout of the same law again, standard deviation and largest [m], in the window.

    `known` is by the record; `show` is called with what is done, and the share of it.

    Orders that are those of the record give its readings, and its payout, to the last bit. NaN: not asked, as the
    record's controller was another one.
    """
    record = known.past.record
    if known.again.is_same:
        return 0.0, 0.0
    if not record.is_own:
        return math.nan, math.nan
    words, ticks = "the same law again, closed", record.ticks
    asked = Asked(words, known.nominal, None, record.has_adviser)
    done = replay(known.past, asked, on_tick=lambda tick: show_some(show, words, tick, ticks))
    error = (done.payout - known.past.winch.payout)[known.window]
    return float(np.std(error)), float(np.abs(error).max())
