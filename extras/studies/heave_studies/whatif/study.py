"""From what a record shows to answers: each loop that is asked for, with its bands."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from heave_node.kpi import significant

from heave_studies.whatif.answer import Figures, Spread, figures, possible, unit_motion, with_bands
from heave_studies.whatif.identify.cable import CableFit
from heave_studies.whatif.known import OFF, Known, off_sigma
from heave_studies.whatif.twin.plant import driven
from heave_studies.whatif.twin.replay import Asked, Replayed, replay
from heave_studies.whatif.work import HERE, Work


@dataclass(frozen=True)
class Answer:
    """What one loop would have done."""

    asked: Asked  # for it
    figures: Figures  # with their bands
    done: Replayed = field(repr=False)  # motions
    plants: int  # number of plants over which it was closed
    lost: int  # number of them on which it gives up compensation, or never begins
    cause: str  # the alarm with which it does; empty: it does not

    @property
    def fade_out(self) -> float:
        """Share of the plants on which it gives up compensation, or never begins [-]."""
        return self.lost / self.plants


def answers(
    known: Known,
    wanted: Sequence[Asked],
    others: Sequence[Known] = (),
    plants: Sequence[CableFit] = (),
    *,
    work: Work = HERE,
) -> list[Answer]:
    """Return what the loops that are asked for would have done.

    Parameters
    ----------
    known : by the record
    wanted : controllers and winches
    others : draws of what the record allows, over which each loop is closed again, for the bands
    plants : draws of cable, unit and MRU, on which its payout is tried
    work : that closes loops
    """
    tasks = [(one, asked) for asked in wanted for one in (known, *others)]
    seen = [_seen(one, asked) if one is known or _is_off(asked) else None for one, asked in tasks]
    open_ = [(one.past, asked) for (one, asked), done in zip(tasks, seen, strict=True) if done is None]
    closed = iter(work.done("closing loops", replay, open_))
    done, count = [next(closed) if one is None else one for one in seen], 1 + len(others)
    loops = [done[number : number + count] for number in range(0, len(done), count)]
    on_plants = _on_plants(known, wanted, [of_law[0] for of_law in loops], plants, work)
    return [
        _answer(known, asked, of_law, others, on_plant)
        for asked, of_law, on_plant in zip(wanted, loops, on_plants, strict=True)
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


def _on_plants(
    known: Known, wanted: Sequence[Asked], loops: Sequence[Replayed], plants: Sequence[CableFit], work: Work
) -> list[list[Figures]]:
    """Return, for each loop that is `wanted`, its figures with the payout of what is `known` on each of other `plants`.

    `loops` are what each of them does over what is known.
    """
    if not plants:
        return [[] for _ in wanted]
    others = known.under(plants, partial(work.done, "motions of other plants", driven))
    tasks = [
        one.past.drive(done.payout, done.rate)
        for asked, done in zip(wanted, loops, strict=True)
        if not _is_off(asked)
        for one in others
    ]
    motions = iter(work.done("motions of each law on other plants", driven, tasks))

    def figures_on(one: Known, asked: Asked, done: Replayed) -> Figures:
        if _is_off(asked):
            return _figures(one, one.off)
        motion = next(motions)
        return _figures(one, replace(done, unit=motion.unit, tension=motion.tension))

    return [[figures_on(one, asked, done) for one in others] for asked, done in zip(wanted, loops, strict=True)]


def _answer(
    known: Known, asked: Asked, loops: Sequence[Replayed], others: Sequence[Known], on_plants: Sequence[Figures]
) -> Answer:
    """Return what a loop would have done.

    Parameters
    ----------
    known : by the record
    asked : for the loop
    loops : what it does over that, and over each draw
    others : draws of what is known
    on_plants : its figures on other plants
    """
    done, *drawn = loops
    base = _figures(known, done)
    draws = [_figures(one, what) for one, what in zip(others, drawn, strict=True)]
    past, window = known.past, known.window
    spread = Spread(
        loops=[one.beside(base) for one in draws],
        plants=[one.beside(base) for one in on_plants],
        added=float(np.std((done.unit + done.set_point - past.plant.unit - known.set_point)[window])),
        locked=float(np.std((known.off.unit - past.plant.unit)[window])),
        model=known.model,
    )
    found = with_bands(base, spread, off_sigma(known), known.by_tip)
    if _is_off(asked):
        # it is the reference of the efficiency
        found = replace(found, bands={**found.bands, "unit_efficiency": (0.0, 0.0)})
    lost = [one for one in (base, *draws) if math.isfinite(one.lost_at)]
    return Answer(asked, found, done, len(loops), len(lost), lost[0].cause if lost else "")


def _figures(known: Known, done: Replayed) -> Figures:
    record = known.past.record
    is_read = bool(np.isfinite(record.tension).any())
    tension = record.tension + done.tension - known.past.plant.tension if is_read else done.tension
    unit = unit_motion(done, known.unexplained)
    return figures(
        done,
        unit,
        np.maximum(np.where(np.isfinite(tension), tension, done.tension), 0.0),
        sigma=known.sigma(unit),
        window=known.window,
        uncompensated=off_sigma(known),
        tick_period=record.tick_period,
    )


def recorded(known: Known, found: Sequence[Answer] = ()) -> Figures:
    """Return the figures of the record itself, by what is `known` of it.

    They have bands where the winch locked is among the answers that were `found`: of the unit from what the depth
    sensor shows alone to that and all that is not known of the boom tip; of the efficiency, with those of the locked
    winch.
    """
    figures, off = _figures(known, _as_recorded(known)), next((one for one in found if _is_off(one.asked)), None)
    if off is None:
        return figures
    low, high = known.sigma_ends(unit_motion(_as_recorded(known), known.unexplained))
    sigma, value = figures.values["unit_sigma_m"], figures.values["unit_efficiency"]
    free, (free_low, free_high) = off.figures.values["unit_sigma_m"], off.figures.bands["unit_sigma_m"]
    # each end by both errors, which have nothing to do with one another
    ends = (
        value - math.hypot(high - sigma, sigma * (free / max(free_low, 1e-9) - 1.0)) / free,
        value + math.hypot(sigma - low, sigma * (1.0 - free / max(free_high, 1e-9))) / free,
    )
    bands = {"unit_sigma_m": (low, high), "significant_residual_m": (significant(low), significant(high))}
    return replace(figures, bands=possible({**bands, "unit_efficiency": ends}))


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
