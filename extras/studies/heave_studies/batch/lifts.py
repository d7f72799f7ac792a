"""Cases of one system in many seas, each as a record of the loop: the plant's own kernels under a fixed law.

As in the loop in one process: sea and boom-tip heave, the noise of MRU, depth sensor and encoder (by the same seeds),
servo, delays, law, the fade-in of compensation, and the lines, which hang straight down (`line`); a locked one that
comes slack is the plant's own. Not so: the filter is the stationary one of the
design, its gains straight in the noises and in the height of the sea as seen; compensation begins when the settling
time is over, and waits for no proof; the boom tip moves vertically alone; no gate, mode, alarm or adviser acts. Where
one of them would matter the lift is flagged, and belongs into the full loop.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from cable_sim_node.line.arrays import LineArrays
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.winch import drive
from heave_bringup.closed_loop import COLUMNS, LoopParameters, LoopRecord, loop_parameters
from heave_bringup.scenarios import Scenario
from heave_node.numerics.arrays import Array
from heave_node.numerics.randomness import random_stream
from wave_vessel_node.component import boom_tip_heave
from wave_vessel_node.mru.mru import MotionReferenceUnit
from winch_controller_node.core.supervision.modes import Mode
from winch_controller_node.design.design import ControllerDesign, design_controller
from winch_controller_node.design.prediction import sensor_periods
from winch_controller_node.design.seas import GROUP_MEMORY, GROUP_SHARE, MEMORY, PATIENCE, STEP
from winch_controller_node.model.lqr import DesignError

from heave_studies.batch.kernel import Control, Course, Timing, fly, hang, hang_alone, heights_seen
from heave_studies.batch.law import READINGS, control_of, law_gain, noises_seen, not_covered, settling_share
from heave_studies.batch.line import LANES, SEEN_GONE, SEEN_STRAIN, WHY_GONE, lanes_of, why_no_lanes

NEAR = 0.8
"""Share of a limit of the winch from which on the law is not the free one (`near_limits.BEGINS` of the controller)."""
LEFT = 0.2
"""Share of the locked unit's motion that is left from which on authority may be less than 1: 1 / (1 + 0.2^2) = 0.96."""
NOT_SETTLED = 0.05
"""Share of the motion from before compensation that may be left when the transient ends."""

SEA_TRACKER = (MEMORY, GROUP_MEMORY, PATIENCE, GROUP_SHARE, STEP)
"""By what the filter follows the height of the sea, see `heights_seen`."""

_NONE = np.zeros(1)
NO_CONTROL = Control(
    np.zeros((1, 1)), _NONE, np.zeros((4, 1)), np.zeros((1, 4, 1)), np.zeros((4, 1, 4, 1)), _NONE, _NONE, (0, 0)
)


class NotCoveredError(ValueError):
    """A case that belongs into the full loop; its message says why."""


@dataclass(frozen=True)
class Flown:
    """A lift that was screened."""

    record: LoopRecord  # as the loop in one process leaves it
    strain: float  # largest of the cable [-]
    flag: str = ""  # why it belongs into the full loop; "": it does not


class LiftBatch:
    """Lifts of one case under many seeds.

    Parameters
    ----------
    scenario : of the case, whatever its seed

    Raises NotCoveredError where no screening covers the case.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._scenario, self._p = scenario, loop_parameters(scenario)
        if words := not_covered(scenario):
            raise NotCoveredError(words)
        p, dt = self._p, self._p.tick_period
        self._ticks = round(p.duration / dt)
        self._moves = scenario.moves_winch
        self._control, start = (self._designed(), self._start) if self._moves else (NO_CONTROL, self._ticks + 2)
        modes, depth = p.controller.modes, p.plant.sensors.depth
        self._timing = Timing(
            tick_period=dt,
            length=p.plant.length,
            height=p.sea.boom_tip_height,
            start=start,
            fade_in=dt / modes.fade_in_time,
            delay=round(p.winch.command_delay / dt),
            depth_period=max(1, round(1.0 / (depth.rate * dt))),
            depth_age=round(depth.latency / dt),
            resolution=p.winch.encoder.resolution,
            power_limit=p.winch.power_limit or math.inf,
        )
        self._servo = drive.as_array(drive.settings_of(p.winch))
        self._rest = CableDynamics(p.plant)
        self._rest.start_at_equilibrium(np.array([0.0, 0.0, p.sea.boom_tip_height]), 0.0, time=dt)
        if words := why_no_lanes(self._rest.arrays, dt):
            raise NotCoveredError(words)

    @property
    def _start(self) -> int:
        """Tick at which compensation begins."""
        return round(self._p.controller.modes.settling_time / self._p.tick_period) + 1

    def _designed(self) -> Control:
        p, dt = self._p.controller, self._p.tick_period
        try:
            design = design_controller(p, tick_period=dt)
            gain = law_gain(design)
            if gain is None:
                raise NotCoveredError(f"law {p.law} with a preview")
            self._check_readings(design)
            begun = self._start * dt + p.modes.fade_in_time
            left = settling_share(design, gain, self._scenario.run.transient - begun)
            if left > NOT_SETTLED:
                raise NotCoveredError(f"{100 * left:.0f} % of a swing is left when the transient ends")
            self._tip_sigma = design.sigma["boom_tip_heave"]
            return control_of(design, gain)
        except DesignError as error:
            raise NotCoveredError(" ".join(str(error).split())) from error

    def _check_readings(self, design: ControllerDesign) -> None:
        """Refuse readings that the kernel does not give, and those that come otherwise than the filter assumes."""
        p, dt = self._p, self._p.tick_period
        for measured in design.measurements:
            if np.any(measured.row) and (measured.name not in READINGS or measured.scale_state is not None):
                raise NotCoveredError(f"reading {measured.name}")
        depth, mru = p.plant.sensors.depth, p.sea.mru
        rates = {"depth": (depth.rate, depth.latency), "mru": (mru.rate or 1.0 / dt, mru.latency)}
        for name, (rate, latency) in rates.items():
            ticks = max(1.0, 1.0 / (rate * dt)), latency / dt
            if not np.allclose(ticks, sensor_periods(design)[name], rtol=0.0, atol=1e-6):
                raise NotCoveredError(f"readings of {name} that come between ticks, or otherwise than assumed")

    def fly(self, seeds: Sequence[int]) -> list[Flown]:
        """Run the lift in the sea of each of the `seeds`.

        Raises NotCoveredError where the sea has no components that last.
        """
        return [
            one for first in range(0, len(seeds), LANES) for one in self._side_by_side(seeds[first : first + LANES])
        ]

    def _side_by_side(self, seeds: Sequence[int]) -> list[Flown]:
        """Run the lift in the seas of at most LANES `seeds`; lanes that are left run the last one again."""
        timing, course = self._timing, self._course([*seeds, *[seeds[-1]] * (LANES - len(seeds))])
        locked = np.zeros((self._ticks, 4, LANES))
        lanes = lanes_of(self._rest.arrays)
        hang(lanes, course, timing, locked)
        lost = [
            lane for lane in range(len(seeds)) if lanes.seen[SEEN_GONE, lane] and not self._hang(lane, course, locked)
        ]
        rows = np.zeros((LANES, self._ticks, len(COLUMNS)))
        lanes = lanes_of(self._rest.arrays)
        fly(lanes, locked, self._control, course, timing, self._servo, rows)
        waits = min(timing.start - 1, self._ticks) if self._moves else 0
        modes = [Mode.STANDBY.value] * waits
        modes += [(Mode.COMPENSATING if self._moves else Mode.OFF).value] * (self._ticks - waits)
        found = []
        for lane, gone in enumerate(lanes.seen[SEEN_GONE, : len(seeds)].astype(int)):
            record = LoopRecord(rows[lane], modes)
            flag = "the line could not be followed" if lane in lost else WHY_GONE[gone] or self._flag(record)
            found.append(Flown(record, float(lanes.seen[SEEN_STRAIN, lane]), flag))
        return found

    def _hang(self, lane: int, course: Course, locked: Array) -> bool:
        """Run the locked line of one lift by the plant's own; return whether it could be followed."""
        line = LineArrays(*(part.copy() for part in self._rest.arrays))
        return bool(hang_alone(line, course, self._timing, lane, locked))

    def _course(self, seeds: Sequence[int]) -> Course:
        of_seed = {seed: self._sea(seed) for seed in dict.fromkeys(seeds)}
        return Course(*(np.stack(parts, axis=-1) for parts in zip(*(of_seed[seed] for seed in seeds), strict=True)))

    def _sea(self, seed: int) -> tuple[Array, Array, Array, Array]:
        """Return what comes to the lift of a `seed`, as `Course` has it of each."""
        p, count = self._p, self._ticks + 1
        heave = boom_tip_heave(p.sea, seed, p.tick_period, count)
        if heave is None:
            raise NotCoveredError("a sea without components that last")
        tips = heave[:, :2] + [p.sea.boom_tip_height, 0.0]
        readings = MotionReferenceUnit(p.sea.mru, seed=seed, tick_period=p.tick_period).series(heave)
        noise = p.plant.sensors.depth.noise * random_stream(seed, "cable_sim/depth").standard_normal(count)
        levels = self._levels(heave[:, 0], readings, noise) if self._moves else np.zeros((count, 4))
        return tips, readings, noise, levels

    def _levels(self, heave: Array, readings: Array, depth_noise: Array) -> Array:
        """Return what the filter assumes of noises and sea at each tick, see `Course`."""
        mru, depth, timing = self._p.sea.mru, self._p.plant.sensors.depth, self._timing
        levels = np.zeros((len(readings), 4))
        due = np.flatnonzero(np.isfinite(readings[:, 0]))
        for column, nominal in enumerate((mru.noise, mru.rate_noise)):
            levels[due, column] = noises_seen(readings[due, column], nominal)
        # a unit that is held moves so little that its third differences are noise
        measured = np.arange(timing.depth_period - 1, len(readings) - timing.depth_age, timing.depth_period)
        levels[measured + timing.depth_age, 2] = noises_seen(depth_noise[measured], depth.noise)
        levels[:, 3] = np.log(heights_seen(heave, timing.tick_period, self._tip_sigma, SEA_TRACKER))
        return levels

    def _flag(self, record: LoopRecord) -> str:
        """Return why a lift belongs into the full loop; "" where it does not."""
        judged = LoopRecord(record.rows[record.rows[:, 0] >= self._scenario.run.transient])
        for flags, seen in ((FLAGS, record), (FLAGS_OF_WINCH, judged)):
            for words, happens in flags.items():
                if happens(seen, self._p):
                    return words
        begun = (self._start - 1) * self._p.tick_period + self._p.controller.modes.fade_in_time
        if self._moves and _left(record, begun) > LEFT:
            return f"more than {100 * LEFT:.0f} % of the motion is left"
        return ""


def _any(record: LoopRecord, name: str, limit: float = 0.0) -> bool:
    return bool(np.abs(record.column(name)).max(initial=0.0) > limit)


def _near_power(record: LoopRecord, p: LoopParameters) -> bool:
    power = np.abs(record.column("top_tension") * record.column("payout_rate"))
    return bool(p.winch.power_limit and power.max() > NEAR * p.winch.power_limit)


def _near_ends(record: LoopRecord, p: LoopParameters) -> bool:
    ends = np.array([p.winch.payout_minimum, p.winch.payout_maximum]) - p.controller.limits.payout_margin * np.array(
        [-1.0, 1.0]
    )
    payout = record.column("payout")
    return bool(payout.min() < NEAR * ends[0] or payout.max() > NEAR * ends[1])


def _near_tensions(record: LoopRecord, p: LoopParameters) -> bool:
    tension, limits = record.column("top_tension") / record.column("top_tension")[0], p.controller.limits
    highest = limits.maximum_tension_ratio or math.inf
    return bool(tension.min() < limits.minimum_tension_ratio + (1.0 - NEAR) or tension.max() > NEAR * highest)


FLAGS: dict[str, Callable[[LoopRecord, LoopParameters], bool]] = {
    "near the ends of the payout": _near_ends,
    "near the tensions that the law keeps": _near_tensions,
}
"""What happens in a lift that belongs into the full loop, in words."""
FLAGS_OF_WINCH: dict[str, Callable[[LoopRecord, LoopParameters], bool]] = {
    "a limit of the winch": lambda record, _: _any(record, "limits_hit"),
    "near the winch's speed": lambda record, p: _any(
        record, "payout_rate", NEAR * p.winch.speed_limit * p.winch.hauling_speed_share
    ),
    "near the winch's acceleration": lambda record, p: _any(
        record, "payout_acceleration", NEAR * p.winch.acceleration_limit * p.winch.hauling_acceleration_share
    ),
    "near the winch's power": _near_power,
}
"""The same, in the time that is judged: what the first swing asks for is over by then."""


def _left(record: LoopRecord, begun: float) -> float:
    """Return the unit's motion over that with the winch locked, from the time `begun` [s] on [-]."""
    off = record.uncompensated_sigma(begun)
    return record.unit_sigma(begun) / off if off > 0.0 else math.inf
