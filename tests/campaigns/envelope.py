"""Faults with the envelope and without it: how far the drum runs, and what becomes of the load.

    python -m tests.campaigns.envelope --case "frozen encoder b2 seed 3" --case "belief encoder 0.05 b3 seed 1"

Without --case all are run, each with the envelope and without. A row says: largest travel of the drum from where it was
at the fault, the requested move taken off, and its largest speed; largest heave of the load about its set-point beside
that of a load under a locked winch, and its spread over that of a locked one from 10 s after the fault; tension; and
what the envelope did first. Components run in this process.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from heave_bringup.closed_loop import COLUMNS, ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario
from heave_core.envelope_table import Cause, Phase
from heave_core.library import READING_NAMES
from winch_controller_node.beliefs.beliefs import Belief, Beliefs, EncoderScale, parameters_under
from winch_controller_node.design.design import design_controller

from tests.campaigns.commit import commit_line

AFTER = 60.0
"""Time that is looked at from the fault on [s]."""

SCENARIOS = {"b2": "b2_calm_300", "b3": "b3_deep_900"}

LATE = 10.0
"""Time after the fault from which on the spread counts [s]."""

HEAD = (
    "| case | drum travel off / with [m] | drum speed [m/s] | load largest off, with / locked [m] | spread over locked "
    "off / with | tension off, with [kN] | bound before | envelope | ends in |\n|---|---|---|---|---|---|---|---|---|"
)
"""Head of the table."""

Change = Callable[[ClosedLoop], None]


@dataclass(frozen=True)
class Case:
    """A fault."""

    kind: str  # of the fault
    scenario: str  # of the run
    seed: int  # of the run
    start: float  # of the fault [s]
    settings: tuple[str, ...] = ()  # of the run: a fault of a sensor that a scenario can state
    change: Change | None = None  # what else becomes of the loop at the fault; None: nothing
    note: str = ""  # what is special about the run

    @property
    def name(self) -> str:
        """Its name."""
        return " ".join(filter(None, (self.kind, self.scenario, f"seed {self.seed}", self.note)))


def fault(group: str, kind: str, start: float, magnitude: float = 0.0) -> tuple[str, ...]:
    """Return the settings of a fault that stays: of a `group`, a `kind`, from a `start` [s] on."""
    values = {"kind": kind, "start": start, "duration": 0.0, "magnitude": magnitude}
    return tuple(f"{group}.faults.{name}=[{value}]" for name, value in values.items())


class Liar:
    """An adviser that has one answer.

    Parameters
    ----------
    beliefs : of that answer
    """

    def __init__(self, beliefs: Beliefs) -> None:
        self._beliefs = beliefs

    def advise(self, observations: Any) -> Beliefs:
        """Return it, whatever the `observations`."""
        return Beliefs(
            observations.last,
            self._beliefs.number,
            self._beliefs.values,
            self._beliefs.encoder,
            design=self._beliefs.design if observations.beliefs != self._beliefs.number else None,
        )


def believing(quantity: str, value: float) -> Change:
    """Return the change to an adviser that says a `quantity` has a `value`."""

    def change(loop: ClosedLoop) -> None:
        controller = loop.controller
        values = MappingProxyType({quantity: Belief(quantity, value, 0.01, 100.0, loop.tick)})
        encoder = None
        if quantity == "encoder.scale":
            payout = loop.winch.state.encoder_payout
            encoder = EncoderScale(loop.tick, value, payout, payout)
        beliefs = Beliefs(loop.tick, 1000, values, encoder)
        if encoder is None:
            design = design_controller(parameters_under(beliefs, controller.nominal), tick_period=0.05)
            beliefs = Beliefs(loop.tick, 1000, values, encoder, design=design)
        loop.adviser = Liar(beliefs)  # type: ignore[assignment]

    return change


def order_times(factor: float) -> Change:
    """Return the change to a controller whose order, before the envelope, is `factor` times what it means."""

    def change(loop: ClosedLoop) -> None:
        command: Any = loop.controller._command
        leave, ordered = command.leave, loop.controller.envelope.records["readings"]

        def leave_times() -> Any:
            ordered[READING_NAMES.index("rate")] *= factor
            return leave()

        command.leave = leave_times

    return change


def drive_times(factor: float) -> Change:
    """Return the change to a winch that takes `factor` times the rate that it is sent."""

    def change(loop: ClosedLoop) -> None:
        winch: Any = loop.winch
        step = winch.step
        winch.step = lambda tick, command, tension: step(
            tick, command._replace(payout_rate=factor * command.payout_rate), tension
        )

    return change


ENCODER, MRU, DEPTH = "virtual_winch.encoder", "wave_vessel.mru", "cable_sim.sensors.depth"
MOVE = (
    "winch_controller.programme.move_times=[60.0]",
    "winch_controller.programme.move_payouts=[8.0]",
    "winch_controller.programme.move_speeds=[0.4]",
)
NO_DEPTH = ("cable_sim.sensors.depth.fitted=false",)
START, LATER = 100.0, 120.0


def _cases() -> tuple[Case, ...]:
    frozen = [("b2", 3), ("b2", 1), ("b2", 12), *(("b3", seed) for seed in range(1, 7))]
    both: list[tuple[str, Change]] = [
        ("belief encoder 0.05", believing("encoder.scale", 0.05)),
        ("belief inertia x5", believing("cable.inertia_factor", 5.0)),
        ("belief delay 1 s", believing("winch.command_delay", 1.0)),
        ("order x100", order_times(100.0)),
    ]
    return (
        *(Case("frozen encoder", name, seed, LATER, fault(ENCODER, "freeze", LATER)) for name, seed in frozen),
        *(Case(kind, name, 1, START, change=change) for name in SCENARIOS for kind, change in both),
        Case("drive x100", "b2", 1, START, change=drive_times(100.0)),
        Case("drive x3", "b2", 1, START, change=drive_times(3.0)),
        Case("drive reversed", "b2", 1, START, change=drive_times(-1.0)),
        *(
            Case(kind, name, 1, START, fault(group, what, START, magnitude))
            for name in SCENARIOS
            for kind, group, what, magnitude in (
                ("MRU scale 2", MRU, "scale", 2.0),
                ("encoder scale 0.5", ENCODER, "scale", 0.5),
                ("MRU reversed", MRU, "scale", -1.0),
                ("MRU gap", MRU, "gap", 0.0),
            )
        ),
        Case("encoder nan", "b2", 1, START, fault(ENCODER, "nan", START)),
        Case("depth lost", "b2", 1, START, fault(DEPTH, "gap", START)),
        Case(
            "MRU reversed",
            "b2",
            1,
            0.0,
            fault(MRU, "scale", 0.0, -1.0) + NO_DEPTH,
            note="without depth, from the start",
        ),
        Case("MRU reversed", "b2", 1, START, fault(MRU, "scale", START, -1.0) + NO_DEPTH, note="without depth"),
        Case("MRU scale 2", "b2", 1, START, fault(MRU, "scale", START, 2.0) + NO_DEPTH, note="without depth"),
        *(
            Case("depth lost", name, 1, START, fault(DEPTH, "gap", START) + MOVE, note="after a move")
            for name in SCENARIOS
        ),
        Case("belief encoder 0.05", "b2", 1, START, MOVE, believing("encoder.scale", 0.05), note="after a move"),
    )


CASES = {case.name: case for case in _cases()}
"""All cases, by name."""


class Found(NamedTuple):
    """What became of a case."""

    travel: float  # largest of the drum from where it was at the fault, without the requested move [m]
    speed: float  # its largest [m/s]
    load: float  # largest heave about the set-point [m]
    locked: float  # the same with the winch locked [m]
    spread: float  # of the load over that with the winch locked, from LATE on
    tension: tuple[float, float]  # least and largest at the top [kN]
    bound: tuple[int, int]  # ticks at a bound or beyond before the fault, and after it
    first: str  # when and why the envelope took over; empty: it did not
    mode: str  # at the end
    # codes of all from the fault on
    alarms: tuple[str, ...] = field(default=())  # type: ignore[assignment]


def run(case: Case, *, envelope: bool = True, settings: Sequence[str] = ()) -> Found:
    """Return what becomes of a `case` with or without the `envelope`, and further `settings`."""
    duration = case.start + AFTER if case.start else LATER + AFTER
    given = [
        f"all.duration={duration}",
        f"all.seed={case.seed}",
        f"winch_controller.envelope.active={'true' if envelope else 'false'}",
        *case.settings,
        *settings,
    ]
    loop = ClosedLoop(loop_parameters(load_scenario(SCENARIOS[case.scenario], settings=given)))
    rows, first, mode, alarms = [], "", "", []
    moved, bound = [], [0, 0]
    start = case.start or 25.0
    for tick in range(1, round(duration / 0.05) + 1):
        if case.change is not None and tick == round(case.start / 0.05):
            case.change(loop)
        outputs, row = loop.step()
        rows.append(row)
        moved.append(loop.controller.mean.point.payout)
        last, mode, time = loop.controller.envelope.last, outputs.mode, tick * 0.05
        bound[time >= start] += bool(int(last.bits) & 3 or last.phase != Phase.FREE)
        if last.cause and not first:
            first = f"{time - start:.1f} s {Cause(int(last.cause)).name} {last.value:.2f} against {last.limit:.2f}"
        if time >= start:
            alarms += [alarm.code for alarm in outputs.alarms]
    return _found(np.array(rows), np.array(moved), start, (bound[0], bound[1]), first, mode)._replace(
        alarms=tuple(dict.fromkeys(alarms))
    )


def _found(rows: np.ndarray, moved: np.ndarray, start: float, bound: tuple[int, int], first: str, mode: str) -> Found:
    columns = {name: rows[:, place] for place, name in enumerate(COLUMNS)}
    after, late = columns["time"] >= start, columns["time"] >= start + LATE
    drum = (columns["payout"] - moved)[after]
    locked = columns["uncompensated"] - np.mean(columns["uncompensated"])
    load = columns["unit"] + columns["depth_set_point"] - np.mean(columns["uncompensated"])
    tension = columns["top_tension"][after] / 1e3
    return Found(
        travel=float(np.max(np.abs(drum - drum[0]))),
        speed=float(np.max(np.abs(columns["payout_rate"][after]))),
        load=float(np.max(np.abs(load[after]))),
        locked=float(np.max(np.abs(locked[after]))),
        spread=float(np.std(load[late]) / np.std(locked[late])),
        tension=(float(np.min(tension)), float(np.max(tension))),
        bound=bound,
        first=first,
        mode=mode,
    )


def table_row(name: str, off: Found, on: Found) -> str:
    """Return a row of the table: a case without (`off`) and with the envelope (`on`)."""
    tension = ", ".join(f"{low:.0f}..{high:.0f}" for low, high in (off.tension, on.tension))
    return (
        f"| {name} | {off.travel:.2f} / {on.travel:.2f} | {off.speed:.2f} / {on.speed:.2f} | {off.load:.2f}, "
        f"{on.load:.2f} / {on.locked:.2f} | {off.spread:.2f} / {on.spread:.2f} | {tension} | {on.bound[0]} | "
        f"{on.first or 'nothing'} | {on.mode} |"
    )


def main(words: Sequence[str] | None = None) -> int:
    """Run the cases; the status is 1 where a drum travels further with the envelope than it may."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--case", action="append", choices=list(CASES), metavar="NAME", help="one case; all without")
    parser.add_argument("--set", action="append", default=[], metavar="NODE.PARAM=VALUE", help="for the runs with it")
    parser.add_argument("--only-with", action="store_true", help="run each with the envelope alone")
    given = parser.parse_args(words)
    sys.stdout.write(f"{commit_line()}\n{HEAD}\n")
    largest = 0.0
    for name in given.case or CASES:
        on = run(CASES[name], settings=given.set)
        off = on if given.only_with else run(CASES[name], envelope=False)
        sys.stdout.write(f"{table_row(name, off, on)}\n")
        sys.stdout.flush()
        largest = max(largest, on.travel)
    sys.stdout.write(f"largest travel with the envelope: {largest:.2f} m\n")
    return int(not largest < 3.0 or math.isnan(largest))


if __name__ == "__main__":
    sys.exit(main())
