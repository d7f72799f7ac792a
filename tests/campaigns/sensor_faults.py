"""Never worse than off with a sensor at fault: which of them, how, when and for how long is drawn at random.

    python -m tests.campaigns.sensor_faults --draws 256

One sensor of one of four scenarios is at fault, from the start or in mid-run, for a time or to the end. A draw is kept
whose unit is never worse than 1.05 times the uncompensated one over any minute that begins 30 s after the trouble does,
or after it ends; where encoder or motion reference unit are lost, or the encoder is reversed from the start, so
that the winch has to stop, than 1.2 times: a unit that is let go at rest swings at first. Components run in this
process. What is named besides the sensor is printed.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from heave_bringup.closed_loop import ClosedLoop, LoopRecord, loop_parameters
from heave_bringup.scenarios import load_scenario
from heave_node.interface.alarm import alarms_in
from heave_studies.promise.deviation import GROUPS, LARGEST_LOST, LOST_KINDS, drawn_fault
from heave_studies.promise.findings import blamed_by

from tests.campaigns.commit import commit_line
from tests.campaigns.promise import LARGEST, TROUBLE, worst_window

SCENARIOS = ("b2_calm_300", "b3_deep_900", "b4_limit_900_tp10", "b10_real_mru_swell")
LAWS = ("mpc", "lqg")
DURATION = 300.0
"""Duration of a run [s]."""


@dataclass(frozen=True)
class Draw:
    """A fault."""

    number: int  # of the draw, and the seed of its sea
    scenario: str  # of the run
    law: str  # of the run
    sensor: str  # at fault
    kind: str  # how
    start: float  # when [s]
    duration: float  # for how long [s]; 0: to the end
    magnitude: float  # of the kind

    @property
    def settings(self) -> list[str]:
        """Parameters of the run."""
        faults = f"{GROUPS[self.sensor]}.faults"
        return [
            f"{faults}.kind=[{self.kind}]",
            f"{faults}.start=[{self.start}]",
            f"{faults}.duration=[{self.duration}]",
            f"{faults}.magnitude=[{self.magnitude}]",
            f"winch_controller.law={self.law}",
            f"all.duration={DURATION}",
            f"all.seed={self.number + 1}",
        ]

    @property
    def largest(self) -> float:
        """Largest standard deviation of the unit over that of the uncompensated one."""
        is_lost = self.kind in LOST_KINDS and self.sensor in ("mru", "encoder")
        is_reversed = self.kind == "scale" and self.sensor == "encoder" and self.magnitude < 0.0 and self.start == 0.0
        return LARGEST_LOST if is_lost or is_reversed else LARGEST

    @property
    def words(self) -> str:
        """Return it in words."""
        lasting = f"for {self.duration:.0f} s" if self.duration > 0.0 else "to the end"
        return (
            f"{self.number:3d} {self.scenario:20s} {self.law:3s} {self.sensor:9s} {self.kind:7s} {self.magnitude:6.2f} "
            f"from {self.start:3.0f} s {lasting:10s}"
        )


def draw(number: int) -> Draw:
    """Return draw `number`."""
    random = np.random.default_rng([17, 256, number])
    sensor, kind, magnitude = drawn_fault(random)
    return Draw(
        number=number,
        scenario=str(random.choice(SCENARIOS)),
        law=str(random.choice(LAWS)),
        sensor=sensor,
        kind=kind,
        start=0.0 if random.random() < 0.3 else round(float(random.uniform(40.0, 150.0)), 2),
        duration=0.0 if random.random() < 0.5 else round(float(random.uniform(2.0, 80.0)), 2),
        magnitude=magnitude,
    )


@dataclass(frozen=True)
class Kept:
    """How the promise was kept."""

    worst: float  # largest ratio of unit and uncompensated one over a minute
    at: float  # where that minute begins [s]
    holds: bool  # the unit was never worse than it may be
    share: float  # of the time from the first minute and a half on in which the loop compensates
    is_named: bool  # the sensor at fault is named
    wrong: tuple[str, ...]  # what else is
    alarms: tuple[str, ...]  # all that were given


def run(one: Draw) -> Kept:
    """Run a draw."""
    return kept(one, ClosedLoop(loop_parameters(load_scenario(one.scenario, settings=one.settings))).run())


def kept(one: Draw, record: LoopRecord) -> Kept:
    """Return how the promise was kept in the `record` of a draw."""
    time = record.column("time")
    compensates = np.array([mode == "compensating" for mode in record.modes])
    first = float(time[np.argmax(compensates)]) if np.any(compensates) else 60.0
    unit, off = record.column("unit") + record.column("depth_set_point"), record.column("uncompensated")
    end = one.start + one.duration if one.duration > 0.0 else time[-1]
    during, after = time <= end, max(first, end) + TROUBLE
    worst, at = max(
        worst_window(time[during], unit[during], off[during], max(first, one.start) + TROUBLE),
        worst_window(time, unit, off, after),
    )
    alarms = tuple(f"{when:.1f} s: {alarm}" for when, alarm in record.alarms)
    named = [culprit for words in alarms for culprit in culprits(words)]
    return Kept(
        worst=worst,
        at=at,
        holds=worst <= one.largest,
        share=float(np.mean(compensates[time > 90.0])),
        is_named=any(one.sensor in culprit for culprit in named),
        wrong=tuple(words for words in alarms if any(one.sensor not in culprit for culprit in culprits(words))),
        alarms=alarms,
    )


def culprits(words: str) -> list[str]:
    """Return whom the line of an alarm blames; a gain by the encoder may be the winch's or the encoder's."""
    blamed = (blamed_by(alarm, noise=False) for alarm in alarms_in(words))
    return [" or ".join(parts) for parts in blamed if parts]


def show(one: Draw, found: Kept) -> str:
    """Return one line of the table, and one for each alarm that is wrong."""
    line = (
        f"{one.words} worst minute {found.worst:5.3f} at {found.at:3.0f} s, compensates {100 * found.share:3.0f} %, "
        f"{'named' if found.is_named else 'not named'}{'' if found.holds else ' WORSE THAN OFF'}"
    )
    return "\n".join([line, *(f"    wrong: {words}" for words in found.wrong)])


def summary(found: Sequence[Kept]) -> str:
    """Return what all draws came to."""
    ratios = np.array([one.worst for one in found])
    return (
        f"{sum(one.holds for one in found)} of {len(found)} kept, largest "
        f"{np.max(ratios):.3f}; {sum(one.is_named for one in found)} named, {sum(bool(one.wrong) for one in found)} "
        f"with a wrong finding"
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the campaign; return 1 where the promise was broken."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draws", type=int, default=256, metavar="N", help="so many draws (default 256)")
    parser.add_argument("--first", type=int, default=0, metavar="N", help="number of the first one (default 0)")
    parser.add_argument("--sensor", choices=tuple(GROUPS), help="only the draws of this one")
    parser.add_argument("--alarms", action="store_true", help="print all alarms of each run")
    options = parser.parse_args(arguments)
    draws = [draw(number) for number in range(options.first, options.first + options.draws)]
    sys.stdout.write(commit_line() + "\n")
    found = []
    for one in draws:
        if options.sensor not in (None, one.sensor):
            continue
        found.append(run(one))
        lines = [show(one, found[-1]), *(f"    {words}" for words in found[-1].alarms if options.alarms)]
        sys.stdout.write("\n".join(lines) + "\n")
        sys.stdout.flush()
    sys.stdout.write(summary(found) + "\n")
    return 0 if all(one.holds for one in found) else 1


if __name__ == "__main__":
    sys.exit(main())
