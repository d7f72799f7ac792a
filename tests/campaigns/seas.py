"""Seas other than assumed: four scenarios in a grid of seas, with the shipped belief and with the matching one.

    python -m tests.campaigns.seas
    python -m tests.campaigns.seas --law lqg --cell b3_deep_900 4 6 --cell b10_real_mru_swell 4 12

The vessel meets the sea of each cell; the controller assumes the sea of its scenario, or in that of the cell. A
cell is kept whose unit moves at most 1.3 times as much under the shipped belief as under the matching one, and never
more than uncompensated, and whose compensation is not lost where the matching belief keeps it. In a sea that takes the
winch to its limits a few minutes are chance, under either belief: what is not kept there is run again for as long as
its scenario lasts, and that counts. Components run in this process.
"""

from __future__ import annotations

import argparse
import itertools
import sys
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import Scenario, load_scenario

from tests.campaigns.commit import commit_line

SCENARIOS = ("b2_calm_300", "b3_deep_900", "b4_limit_900_tp10", "b10_real_mru_swell")
HEIGHTS = (0.5, 1.0, 2.0, 3.0, 4.0)
"""Significant wave heights [m]."""

PERIODS = (6.0, 8.0, 10.0, 12.0, 14.0)
"""Peak periods [s]."""

DURATION, TRANSIENT = 400.0, 130.0
"""Duration of a first run, and of its beginning that is not judged [s]."""

LARGEST = 1.3
"""Largest standard deviation of the unit over that of the matching belief."""

LARGEST_OF_OFF = 1.05
"""Largest standard deviation of the unit over that of the uncompensated one."""

NEGLIGIBLE = 0.001
"""Standard deviation of the unit that no one would notice, whatever the ratio [m]."""


@dataclass(frozen=True)
class Cell:
    """A scenario in a sea."""

    scenario: str  # its name
    height: float  # significant wave height [m]
    period: float  # peak period [s]


@dataclass(frozen=True)
class Held:
    """What became of the unit."""

    sigma: float  # standard deviation of its heave [m]
    off: float  # the same, not compensated [m]
    share: float  # of the judged time in which it was compensated


@dataclass(frozen=True)
class Outcome:
    """A cell with both beliefs."""

    shipped: Held  # held under the belief that the scenario ships
    matching: Held  # held under that in the cell's sea
    duration: float  # of the run that was judged [s]

    @property
    def holds(self) -> bool:
        """Tell whether the shipped belief does as well as the matching one, and neither does harm."""
        is_close = self.shipped.sigma <= max(LARGEST * self.matching.sigma, self.matching.sigma + NEGLIGIBLE)
        is_harmless = all(held.sigma <= LARGEST_OF_OFF * held.off for held in (self.shipped, self.matching))
        return is_close and is_harmless and self.shipped.share >= self.matching.share - 0.1


def run(cell: Cell, seed: int, law: str = "") -> Outcome:
    """Run a cell with a `seed` and a `law`, with either belief; the scenario's own law where none is named."""
    outcome = _run(cell, seed, law, (f"all.duration={DURATION!r}", f"all.transient={TRANSIENT!r}"))
    return outcome if outcome.holds else _run(cell, seed, law, ())


def _run(cell: Cell, seed: int, law: str, length: Sequence[str]) -> Outcome:
    """Run a cell with either belief; `length` are the settings of its duration and transient, none the scenario's."""
    sea = f"significant_wave_height={cell.height!r}", f"peak_period={cell.period!r}"
    others = [*length, f"all.seed={seed}", *([f"winch_controller.law={law}"] if law else [])]
    scenarios = [
        load_scenario(cell.scenario, settings=[*(f"{owner}.{value}" for value in sea), *others])
        for owner in ("wave_vessel", "system.sea")
    ]
    shipped, matching = (_held(scenario) for scenario in scenarios)
    return Outcome(shipped, matching, scenarios[0].run.duration)


def _held(scenario: Scenario) -> Held:
    record = ClosedLoop(loop_parameters(scenario)).run()
    judged = record.column("time") > scenario.run.transient
    unit = record.column("unit") + record.column("depth_set_point")
    compensates = np.array([mode == "compensating" for mode in record.modes])
    return Held(
        sigma=float(np.std(unit[judged])),
        off=float(np.std(record.column("uncompensated")[judged])),
        share=float(np.mean(compensates[judged])),
    )


def show(cell: Cell, outcome: Outcome) -> str:
    """Return one line of the table."""
    shipped, matching = outcome.shipped, outcome.matching
    told = "" if outcome.duration == DURATION else f", over {outcome.duration:.0f} s"
    told += "" if outcome.holds else " NOT KEPT"
    return (
        f"{cell.scenario:18s} Hs {cell.height:3.1f} Tp {cell.period:4.1f}: {100 * shipped.sigma:6.2f} cm, "
        f"matching belief {100 * matching.sigma:6.2f}, off {100 * shipped.off:6.1f}; "
        f"compensates {100 * shipped.share:3.0f} % and {100 * matching.share:3.0f} %{told}"
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the campaign; return 1 where a cell was not kept."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenarios", nargs="+", default=SCENARIOS, metavar="NAME")
    parser.add_argument("--heights", nargs="+", type=float, default=HEIGHTS, metavar="HS")
    parser.add_argument("--periods", nargs="+", type=float, default=PERIODS, metavar="TP")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--law", default="", help="of all runs (default: that of each scenario)")
    parser.add_argument(
        "--cell", nargs=3, action="append", metavar=("NAME", "HS", "TP"), help="this one, in place of the grid; again"
    )
    options = parser.parse_args(arguments)
    sys.stdout.write(commit_line() + "\n")
    chosen = [Cell(name, float(height), float(period)) for name, height, period in options.cell or ()]
    grid = itertools.starmap(Cell, itertools.product(options.scenarios, options.heights, options.periods))
    kept, cells = 0, chosen or list(grid)
    for cell in cells:
        outcome = run(cell, options.seed, options.law)
        kept += outcome.holds
        sys.stdout.write(show(cell, outcome) + "\n")
        sys.stdout.flush()
    sys.stdout.write(f"{kept} of {len(cells)} kept\n")
    return 0 if kept == len(cells) else 1


if __name__ == "__main__":
    sys.exit(main())
