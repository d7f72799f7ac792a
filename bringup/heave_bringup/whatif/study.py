"""From what a record shows to answers: each loop that is asked for, with its bands."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from heave_bringup.whatif.answer import Figures, Spread, figures, unit_motion, with_bands
from heave_bringup.whatif.known import OFF, Known, Show, off_sigma, quiet, show_some
from heave_bringup.whatif.twin.plant import driven
from heave_bringup.whatif.twin.replay import Asked, Replayed, replay
from heave_bringup.whatif.twin.winch import tension_at_ticks


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


def answer(
    known: Known, asked: Asked, others: Sequence[Known] = (), plants: Sequence[Known] = (), *, show: Show = quiet
) -> Answer:
    """Return what the loop that is `asked` for would have done.

    Parameters
    ----------
    known : by the record
    asked : controller and winch
    others : draws of what the record allows, over which the loop is closed again, for the bands
    plants : draws of cable, unit and MRU, on which its payout is tried
    show : called with what is done, and the share of it
    """
    ticks = known.past.record.ticks
    count = 1 + len(others)
    results = []
    for number, one in enumerate((known, *others)):
        on_tick = partial(_show_of, show, asked.name, number * ticks, count * ticks)
        done = _done(one, asked, on_tick)
        results.append((done, _figures(one, done)))
    (done, base), *draws = results
    past, window = known.past, known.window
    spread = Spread(
        loops=[one for _, one in draws],
        plants=[_figures(one, _on_plant(one, asked, done)) for one in plants],
        added=float(np.std((done.unit + done.set_point - past.moved.unit - known.set_point)[window])),
        locked=float(np.std((known.off.unit - past.moved.unit)[window])),
        model=known.model,
    )
    found = with_bands(base, spread, off_sigma(known))
    if asked.controller.law == OFF:
        # it is the reference of the efficiency
        found = replace(found, bands={**found.bands, "unit_efficiency": (0.0, 0.0)})
    lost = [one for _, one in results if math.isfinite(one.lost_at)]
    return Answer(asked, found, done, len(lost) / count, lost[0].cause if lost else "")


def _on_plant(known: Known, asked: Asked, done: Replayed) -> Replayed:
    """Return what a loop has `done`, with the motions of the plant that is `known`."""
    if asked.controller.law == OFF:
        return known.off
    past = known.past
    motion = driven(past.line, past.length, past.tip, done.payout, done.rate, tick_period=past.record.tick_period)
    return replace(done, unit=motion.unit, tension=motion.tension)


def _done(known: Known, asked: Asked, on_tick: Callable[[int], None]) -> Replayed:
    if asked.controller.law == OFF:
        return known.off
    return replay(known.past, asked, on_tick=on_tick)


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


def recorded(known: Known) -> Figures:
    """Return the figures of the record itself, by what is `known` of it."""
    past, record = known.past, known.past.record
    done = replace(
        known.off,
        payout=past.winch.payout,
        rate=past.winch.rate,
        unit=past.plant.unit,
        tension=past.plant.tension,
        limits_hit=record.limits_hit,
    )
    return _figures(known, done)


def same_again(known: Known, *, show: Show = quiet) -> tuple[float, float]:
    """Return the error of payout of the same law again, standard deviation and largest [m], in the window.

    `known` is by the record; `show` is called with what is done, and the share of it.

    Orders that are those of the record give its readings, and its payout, to the last bit.
    """
    record = known.past.record
    if known.again.is_same:
        return 0.0, 0.0
    words, ticks = "the same law again, closed", record.ticks
    asked = Asked(words, known.nominal, None, record.has_adviser)
    done = replay(known.past, asked, on_tick=lambda tick: show_some(show, words, tick, ticks))
    error = (done.payout - known.past.winch.payout)[known.window]
    return float(np.std(error)), float(np.abs(error).max())
