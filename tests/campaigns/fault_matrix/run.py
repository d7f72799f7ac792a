"""Cases are run: a loop goes to its moment once, and each fault begins in a copy of it, which is a fork."""

from __future__ import annotations

import json
import math
import multiprocessing
import os
import signal
import time as clock
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from itertools import groupby

import numpy as np
from heave_bringup.closed_loop import LoopRecord
from heave_node.interface.alarm import Alarm
from heave_studies.promise.deviation import Chance
from heave_studies.promise.run import DRUM, ENCODER, heave_of
from winch_controller_node.model.blocks import CableModel

from tests.campaigns.fault_matrix.cases import Cell
from tests.campaigns.fault_matrix.faults import ALWAYS, CREEPING, FASTER, MOVING, RESTING
from tests.campaigns.fault_matrix.judge import (
    HELD,
    LARGEST_UNIT,
    SHOWN,
    Raised,
    asked_more,
    blamed,
    envelope_ratio,
    held_for,
    lead_of,
    named_after,
    past_brake,
    path_of,
    rest_after,
    stopped_at_once,
    travel_ratio,
    unit_ratio,
)
from tests.campaigns.fault_matrix.moments import LANDINGS, Asked, Session
from tests.campaigns.fault_matrix.words import false_words

AFTER = 75.0
"""Time that is watched from the beginning of a fault on [s]."""

LIMIT = 300
"""Longest time that a case may take [s]."""


@dataclass(frozen=True)
class Outcome:
    """What a case came to."""

    named: float = math.inf  # time to the alarm that names the part at fault [s]; infinite: none did
    is_visible: bool | None = None  # the fault showed; None: it does not from inside
    rest: float = math.inf  # time to the drum at rest under its brake, or an order to stand [s]; infinite: it goes on
    travel: float = math.nan  # of the drum until then, over the heave of the rolling minute and 0.3 m
    envelope: float = math.nan  # rate or travel over the bounds of the envelope
    # motion of the unit from 10 s after the fault over that of the locked one; NaN: on the bottom, or too short
    unit: float = math.nan
    tension: float = math.nan  # largest tension over that of the locked one
    slack: float = math.nan  # least tension over static
    rate: float = math.nan  # largest of the drum [m/s]
    wrong: tuple[str, ...] = ()  # alarms that blame a healthy part
    alarms: tuple[str, ...] = ()  # the first ones, time after the fault [s] and code
    modes: tuple[str, ...] = ()  # that were taken after the fault
    false_words: tuple[str, ...] = ()  # alarms whose consequence the modes of the next second belie
    failure: str = ""  # why the case could not be run; empty: it could
    # time after the fault at which the drum was stopped at once [s]; infinite: it was not
    sudden: float = math.inf
    # motion of the unit over that of the locked one in the same run without a fault, with an emergency stop where the
    # drum was stopped at once; 0: not asked for
    stopped: float = 0.0
    # travel in that run, over the same limit, where the drum goes further and as long; 0: not asked for
    without: float = 0.0
    past_brake: float = 0.0  # largest way of the drum past a brake that alone may hold it: left out above [m]
    seconds: float = 0.0  # of processor time that it took


def outcome_of(values: dict[str, object]) -> Outcome:
    """Return an outcome from what JSON has of it."""
    return Outcome(**{name: tuple(one) if isinstance(one, list) else one for name, one in values.items()})  # type: ignore[arg-type]


def run_in_processes(cells: Sequence[Cell], after: float, workers: int) -> Iterator[tuple[Cell, Outcome]]:
    """Do `run_cells` in so many `workers`, and yield each loop as it is done; in this process with one."""
    if workers == 1:
        yield from run_cells(cells, after)
        return
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    loops = [list(group) for _, group in groupby(cells, key=lambda one: one.base.number)]
    ignored = (signal.SIGINT, signal.SIG_IGN)  # Ctrl-C ends the first process, which ends the others
    with multiprocessing.get_context("spawn").Pool(workers, signal.signal, ignored) as pool:
        for group in pool.imap_unordered(partial(_whole_loop, after=after), loops):
            yield from group


def _whole_loop(cells: Sequence[Cell], after: float) -> list[tuple[Cell, Outcome]]:
    return list(_run_loop(cells, after))


def run_cells(cells: Sequence[Cell], after: float = AFTER) -> Iterator[tuple[Cell, Outcome]]:
    """Run `cells`, each for a time `after` its fault begins [s]; those of one loop, in a row, share it."""
    for _, branches in groupby(cells, key=lambda one: one.base.number):
        yield from _run_loop(list(branches), after)


def _run_loop(cells: Sequence[Cell], after: float) -> Iterator[tuple[Cell, Outcome]]:
    base = cells[0].base
    try:
        session = Session(base.case.load(duration=1000.0))
        is_reached = base.of.reach(session, Chance("moment", base.case.day, base.number))
        failure = "" if is_reached else f"the moment does not come: {session.mode} at {session.time:.0f} s"
    except Exception as error:  # one loop that cannot be run must not end the others; it stands in the matrix
        failure = _words(error)
    for one in cells:
        found = Outcome(failure=failure) if failure else _forked(one, session, after)
        goes_far = found.travel > 1.0
        if found.unit > LARGEST_UNIT or goes_far:
            other = _forked(one, session, after, stop=found.sudden)
            # a drum that has come to rest is held against one that does as well
            counts = goes_far and (math.isinf(found.rest) or math.isfinite(other.rest))
            found = replace(found, stopped=other.unit, without=other.travel if counts else 0.0)
        yield one, found


def _forked(one: Cell, session: Session, after: float, *, stop: float | None = None) -> Outcome:
    """Return what a case comes to in a copy of the `session`.

    `stop` : time of an emergency stop without the fault [s], infinite: of none; None: with the fault
    """
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        status = 1
        try:
            os.close(reading)
            signal.signal(signal.SIGALRM, signal.SIG_DFL)
            signal.alarm(LIMIT)
            with os.fdopen(writing, "w") as file:
                json.dump(asdict(_branch(one, session, after, stop)), file)
            status = 0
        finally:
            os._exit(status)
    os.close(writing)
    with os.fdopen(reading) as file:
        text = file.read()
    _, status = os.waitpid(child, 0)
    if status or not text:
        return Outcome(failure=f"ended with status {os.waitstatus_to_exitcode(status)} and no answer")
    return outcome_of(json.loads(text))


def _branch(one: Cell, session: Session, after: float, stop: float | None) -> Outcome:
    began = clock.process_time()
    try:
        session.go(one.offset)
        begin = session.time
        nominal = session.loop.controller.design.cable
        if stop is None:
            session.wires.begin(one.fault)
        session.asked = session.asked.left(session.loop.controller.mean)
        if stop is not None and math.isfinite(stop):
            session.go(stop)
            session.set_mode("emergency_stop")
        session.go(begin + after - session.time)
    except Exception as error:  # see `_run_loop`
        return Outcome(failure=_words(error))
    cable = session.scenario.parameters["cable_sim"].cable
    found = judged(
        one,
        session.record,
        np.array(session.brake),
        np.array(session.ordered),
        np.array(session.only_brake),
        session.asked,
        begin,
        cable.axial_stiffness,
        session.scenario.parameters["virtual_winch"].speed_limit,
        nominal,
    )
    return replace(found, seconds=clock.process_time() - began)


def _words(error: Exception) -> str:
    return f"{type(error).__name__}: {' '.join(str(error).split())}"


def judged(
    one: Cell,
    record: LoopRecord,
    brake: np.ndarray,
    ordered: np.ndarray,
    only_brake: np.ndarray,
    asked: Asked,
    begin: float,
    stiffness: float = math.inf,
    speed_limit: float = math.inf,
    nominal: CableModel | None = None,
) -> Outcome:
    """Return what the `record` of a case came to.

    Parameters
    ----------
    one, record : the case and what it left
    brake, ordered : at each tick: the brake is on; rate that the drive was sent [m/s], NaN: to brake; shapes (ticks,)
    only_brake : at each tick: nothing but the brake may hold the drum, shape (ticks,)
    asked : motion of the drum that was asked for
    begin : of the fault [s]
    stiffness : EA of the cable [N]
    speed_limit : of the drive [m/s]
    nominal : cable by which the drum may lead the load; None: it does not
    """
    kind, time = one.fault.kind, record.column("time")
    payout, rate, tip = record.column("payout"), record.column("payout_rate"), record.column("boom_tip")
    past = past_brake(time, payout, ordered, only_brake)
    payout = payout - past
    # the drive may hold a drum that its brake does not
    rest, end = rest_after(time, rate, brake | (ordered == 0.0), begin), begin + (one.fault.duration or math.inf)
    alarms = [raised(at, alarm) for at, alarm in record.alarms]
    allowed = (*kind.parts, *one.base.case.parts)
    since = time >= begin
    tension, locked = record.column("largest_top_tension"), record.column("uncompensated_largest_tension")
    # driven by hand, the drum goes no certain way: nothing brings it back to what was asked
    counts_otherwise = math.isinf(asked.distance) or bool({ENCODER, DRUM} & set(one.base.case.parts))
    stands = one.base.of.scenarios is LANDINGS
    modes = record.modes[int(np.argmax(since)) :]
    planned = record.column("depth_set_point")
    lead = swing = 0.0 * time
    if nominal is not None:
        stretch, follows = record.column("top_tension") / nominal.stiffness, np.array(record.modes) == "compensating"
        lead = lead_of(time, planned, stretch, follows, asked, nominal)
        swing = lead / math.sqrt(nominal.natural_a)
    return Outcome(
        named=named_after(alarms, kind.parts, begin),
        is_visible={
            ALWAYS: True,
            MOVING: path_of(time, rate, np.nan_to_num(ordered), begin, end) > SHOWN,
            FASTER: asked_more(ordered, one.fault.magnitude * speed_limit, time, begin, end),
            CREEPING: one.fault.magnitude * held_for(time, ~brake, begin, end) > SHOWN,
            RESTING: held_for(time, np.isnan(ordered), begin, end) > HELD,
        }.get(kind.shows),
        rest=rest,
        travel=travel_ratio(time, payout, tip, asked, begin, begin + rest),
        envelope=envelope_ratio(time, payout, planned, tip, asked, begin, lead, swing),
        unit=math.nan
        if stands
        else unit_ratio(
            time,
            heave_of(record, stiffness, counts_otherwise=counts_otherwise) + past,
            record.column("uncompensated"),
            begin,
        ),
        tension=float(np.max(tension[since]) / np.max(locked)),
        slack=float(np.min(record.column("top_tension")[since]) / np.mean(record.column("uncompensated_tension"))),
        rate=float(np.max(np.abs(rate[since]))),
        wrong=tuple(dict.fromkeys(one.code for one in blamed(alarms, allowed, begin))),
        alarms=tuple(f"{one.time - begin:.2f} {one.code}" for one in alarms if one.time >= begin)[:12],
        modes=tuple(mode for mode, _ in groupby(modes)),
        false_words=tuple(false_words(record, begin)),
        sudden=stopped_at_once(time, rate, begin, rest),
        past_brake=float(np.max(np.abs(past))),
    )


def raised(time: float, alarm: Alarm) -> Raised:
    """Return an `alarm` of a record as it is judged."""
    return Raised(time, alarm.name, alarm.row.part, alarm.severity, alarm.text)
