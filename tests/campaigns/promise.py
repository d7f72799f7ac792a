"""Never worse than off: winches, sensors and seas that differ from what the controller assumes (benchmark B9).

    python -m tests.campaigns.promise --draws 256

The controller assumes scenario b3_deep_900 as it is. Of the truth are drawn: limits of speed and acceleration, of
hauling in apart, of power, the servo, its gain, delay, dead zone, the encoder's play, the radius of the drum, the
noise of MRU and depth sensor, stamps of the MRU and its high-pass, the sea. A draw is kept whose unit is never worse
than 1.05 times the uncompensated one over any minute that begins 30 s after compensation does. Components run in this
process. --plant draws mass, damping and drag of the unit besides, as campaign b9_model_error does: each draw then has
errors of plant, winch and sensors together. What matters among what was drawn is ranked by the efficiency.

Without --draws the plain table is run: one thing wrong at a time; where that is a sensor, beside a run with an informed
controller: from 60 s after the beginning of compensation on, to the end of 400 s, the unit moves at most twice as
much as in that one.

Fails where a draw is not kept, never compensates, or gets a wrong finding about its winch or sensors.
"""

from __future__ import annotations

import argparse
import math
import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import pandas
from heave_bringup.closed_loop import ClosedLoop, LoopRecord, loop_parameters
from heave_bringup.output import make_table, print_parts
from heave_bringup.scenarios import load_scenario
from heave_node.interface.alarm import Alarm, alarms_in
from heave_node.kpi import WORSE_RATIO, WORSE_WINDOW, window_ratios
from heave_node.numerics.arrays import Array
from heave_studies.promise.deviation import TROUBLE
from heave_studies.promise.findings import blamed_by, changes_in
from heave_studies.study.summary import FEWEST_CASES, influence_rows, influences
from heave_studies.study.table import NOMINAL
from heave_studies.study.workers import FAILURE

from tests.campaigns.commit import commit_line

SCENARIO = "b3_deep_900"
DURATION = 240.0
"""Duration of a run [s]."""

WINDOW = WORSE_WINDOW
"""Length of a window that is judged [s]."""

LARGEST = WORSE_RATIO
"""Largest standard deviation of the unit over that of the uncompensated one."""

HEIGHTS = (1.5, 1.8, 2.8)
"""Significant wave heights [m]."""

SPEED, ACCELERATION, DELAY, SERVO = 2.0, 1.5, 0.2, 0.15
"""The assumed winch [m/s], [m/s^2], [s], [s]."""

NOISES = {"wave_vessel.mru.noise": 0.01, "wave_vessel.mru.rate_noise": 0.01, "cable_sim.sensors.depth.noise": 0.02}
"""Assumed noise [m], [m/s], [m]."""

EFFICIENCY = "unit_efficiency"
"""Figure that is ranked by."""

AS_ASSUMED = {
    **NOISES,
    "virtual_winch.power_limit": 1e6,
    "wave_vessel.mru.high_pass_period": 1e3,
    "wave_vessel.mru.stamp_error": 0.0,
}
"""Values of a draw that does not name them; a power and a period that nothing in these seas reaches stand for none."""

NOISE_ROWS = dict(zip(("mru_heave", "mru_heave_rate", "unit_heave"), NOISES.items(), strict=True))
"""Noise by the names that findings have for the readings."""

INERTIA, DAMPING, DRAG = (
    "winch_controller.cable_model.inertia_factor",
    "winch_controller.cable_model.damping_factor",
    "cable_sim.unit.drag_coefficient",
)
"""Deviations of the plant."""

USUAL_SPEED = 0.3
"""Speed of the drum in the smallest of the seas [m/s]: the scale of dead zone and play."""

Settings = Mapping[str, float]

PLAIN: dict[str, Settings] = {
    "as believed": {},
    "acceleration 0.8": {"virtual_winch.acceleration_limit": 0.8},
    "acceleration 1.0": {"virtual_winch.acceleration_limit": 1.0},
    "hauling in 0.7": {"virtual_winch.hauling_acceleration_share": 0.7 / ACCELERATION},
    "power 100 kW": {"virtual_winch.power_limit": 1e5},
    "speed 1.0": {"virtual_winch.speed_limit": 1.0},
    "MRU noise x5": {"wave_vessel.mru.noise": 0.05, "wave_vessel.mru.rate_noise": 0.05},
    "MRU and depth noise x5": {name: 5.0 * sigma for name, sigma in NOISES.items()},
    "high-pass 30 s": {"wave_vessel.mru.high_pass_period": 30.0},
    "MRU scale 0.85": {"wave_vessel.mru.scale_error": -0.15},
    "drum radius 3 %": {"virtual_winch.drum_radius_error": 0.03},
}
"""One deviation from what is assumed."""

_MRU, _DEPTH = "winch_controller.sensors.mru", "winch_controller.sensors.depth"
TOLD: dict[str, Settings] = {
    "MRU noise x5": {f"{_MRU}.noise": 0.05, f"{_MRU}.rate_noise": 0.05},
    "MRU and depth noise x5": {f"{_MRU}.noise": 0.05, f"{_MRU}.rate_noise": 0.05, f"{_DEPTH}.noise": 0.1},
    "high-pass 30 s": {f"{_MRU}.high_pass_period": 30.0},
    "MRU scale 0.85": {f"{_MRU}.scale_sigma": 0.15},
}
"""The belief of an informed controller about a sensor; of a scale, that it may be so far off."""

LEARNING, TOLD_DURATION = 60.0, 400.0
"""Time from the beginning of compensation within which such a sensor is identified; duration of such a run [s]."""

LARGEST_OVER_TOLD = 2.0
"""Largest standard deviation of the unit from then on over that under the informed belief."""


@dataclass(frozen=True)
class Draw:
    """A truth."""

    name: str  # of the draw
    seed: int  # of its sea and noise
    settings: Settings  # other than assumed
    # the informed belief, where a run under it is the measure; empty: none is
    told: Settings = field(default_factory=dict)


def draw(number: int) -> Draw:
    """Return draw `number`: every error of the winch at once, in a third of the draws one of a sensor as well."""
    random = np.random.default_rng([13, 256, number])

    def between(low: float, high: float) -> float:
        return float(random.uniform(low, high))

    def sometimes(value: float, otherwise: float, share: float) -> float:
        return value if random.random() < share else otherwise

    acceleration = ACCELERATION * between(0.5, 1.1)
    settings = {
        "wave_vessel.significant_wave_height": float(random.choice(HEIGHTS)),
        "wave_vessel.peak_period": between(8.0, 13.0),
        "virtual_winch.speed_limit": SPEED * between(0.5, 1.1),
        "virtual_winch.acceleration_limit": acceleration,
        "virtual_winch.hauling_speed_share": between(0.7, 1.0),
        "virtual_winch.hauling_acceleration_share": between(0.6, 1.0),
        "virtual_winch.power_limit": sometimes(between(1e5, 3e5), 0.0, 0.25),
        "virtual_winch.time_constant": SERVO * between(0.7, 1.3),
        "virtual_winch.command_delay": DELAY + between(-0.1, 0.1),
        "virtual_winch.speed_gain": between(0.8, 1.2),
        "virtual_winch.speed_deadband": sometimes(between(0.0, 0.05), 0.0, 0.5),
        "virtual_winch.encoder.backlash": sometimes(between(0.0, 0.01), 0.0, 0.5),
        "virtual_winch.drum_radius_error": between(-0.03, 0.03),
    }
    which = random.integers(9)
    if which == 0:
        settings |= {name: between(1.0, 5.0) * sigma for name, sigma in NOISES.items()}
    elif which == 1:
        settings["wave_vessel.mru.high_pass_period"] = between(20.0, 60.0)
    elif which == 2:
        settings["wave_vessel.mru.stamp_error"] = 0.05
    return Draw(f"draw {number}", number + 1, settings)


def draw_with_plant(number: int) -> Draw:
    """Return draw `number` with the plant of benchmark B9 besides: mass and damping within 30 %, drag up to four times.

    The winch, the sensors and the sea are those of `draw`.
    """
    random, one = np.random.default_rng([9, 256, number]), draw(number)
    plant = {
        INERTIA: float(random.uniform(0.7, 1.3)),
        DAMPING: float(random.uniform(0.7, 1.3)),
        DRAG: float(random.uniform(1.0, 4.0)),
    }
    return replace(one, name=f"{one.name} with plant", settings={**one.settings, **plant})


def parameters_of(one: Draw, duration: float = DURATION) -> Sequence[str]:
    """Return the settings of a run of so long a `duration` [s]."""
    values: dict[str, float | list[float]] = dict(one.settings)
    if DRAG in one.settings:
        values[DRAG] = 3 * [one.settings[DRAG]]  # along each axis
    acceleration = one.settings.get("virtual_winch.acceleration_limit", ACCELERATION)
    values["virtual_winch.stop_deceleration"] = min(acceleration, ACCELERATION)
    values |= {"all.duration": duration, "all.transient": 30.0, "wave_vessel.ramp": 30.0}
    return [*(f"{name}={value!r}" for name, value in values.items()), f"all.seed={one.seed}"]


@dataclass(frozen=True)
class Kept:
    """How the promise was kept."""

    sigma: float  # standard deviation of the unit from `TROUBLE` after the beginning on [m]
    off: float  # the same, not compensated [m]
    worst: float  # largest ratio of both over a window
    at: float  # where that window begins [s]
    fades: int  # how often compensation was given up
    share: float  # of the time since the first minute and a half in which it compensates
    wrong: tuple[str, ...]  # alarms that name what is not so
    alarms: tuple[str, ...]  # all that were given on winch, sea and sensors
    # standard deviation of the unit from `LEARNING` after the beginning on [m]; NaN: there is none
    learnt: float = math.nan
    told: float = math.nan  # the same under the informed belief [m]

    @property
    def holds(self) -> bool:
        """Tell whether the unit was never worse than off, in one window at least."""
        return self.worst <= LARGEST and math.isfinite(self.at)

    @property
    def is_as_informed(self) -> bool:
        """Return whether what was learnt is about as good as an informed belief."""
        return not self.learnt > LARGEST_OVER_TOLD * self.told

    @property
    def is_kept(self) -> bool:
        """Tell whether the promise is kept, by a loop that compensates and says nothing wrong."""
        return self.holds and self.share > 0.0 and self.is_as_informed and not self.wrong


def run(one: Draw, duration: float = DURATION) -> Kept:
    """Run a draw for a `duration` [s], and for twice as long where compensation begins too late to be judged."""

    def run_for(duration: float) -> Kept:
        scenario = load_scenario(SCENARIO, settings=parameters_of(one, duration))
        return kept(one, ClosedLoop(loop_parameters(scenario)).run())

    if one.told:
        known = replace(one, settings={**one.settings, **one.told}, told={})
        return replace(run(replace(one, told={}), TOLD_DURATION), told=run(known, TOLD_DURATION).learnt)
    found = run_for(duration)
    return found if math.isfinite(found.at) else run_for(2.0 * duration)


def kept(one: Draw, record: LoopRecord) -> Kept:
    """Return how the promise was kept in the `record` of a draw."""
    time = record.column("time")
    unit = record.column("unit") + record.column("depth_set_point")
    off = record.column("uncompensated")
    compensates = np.array([mode == "compensating" for mode in record.modes])
    begin = float(time[np.argmax(compensates)]) + TROUBLE if np.any(compensates) else WINDOW
    ratio, at = worst_window(time, unit, off, begin)
    entered = np.array([mode == "fade_out" for mode in record.modes])
    told = tuple(f"{when:.0f} s: {alarm}" for when, alarm in record.alarms if _is_finding(alarm))
    return Kept(
        sigma=float(np.std(unit[time > begin])),
        learnt=float(np.std(unit[time > begin - TROUBLE + LEARNING])),
        off=float(np.std(off[time > begin])),
        worst=ratio,
        at=at,
        fades=int(np.count_nonzero(entered[1:] & ~entered[:-1])),
        share=float(np.mean(compensates[time > 90.0])),
        wrong=tuple(words for words in told if is_wrong(words, one.settings)),
        alarms=told,
    )


def worst_window(time: Array, unit: Array, off: Array, begin: float) -> tuple[float, float]:
    """Return the largest ratio of standard deviations over any window, and where that begins [s].

    Parameters
    ----------
    time, unit, off : of each tick [s], heave of the unit and of the uncompensated one [m], shape (ticks,)
    begin : of the first window [s]
    """
    starts, ratios = window_ratios(time, unit, off, begin)
    if not ratios.size:
        return 0.0, math.nan
    at = int(np.argmax(ratios))
    return float(ratios[at]), float(starts[at])


def _is_finding(alarm: Alarm) -> bool:
    """Tell whether an `alarm` says what a part is like, or that commands are late."""
    (read,) = alarms_in(str(alarm))
    is_updated = alarm.code in ("WINCH_MODEL_UPDATED", "SEA_MODEL_UPDATED")
    return is_updated or alarm.code.startswith("COMMANDS_") or bool(blamed_by(read))


def is_suspicion(alarm: Alarm) -> bool:
    """Tell whether a raised `alarm` says that a sensor or the cable is not as assumed, other than a lost sensor."""
    (read,) = alarms_in(str(alarm))
    is_lost = alarm.code.startswith("SENSOR_LOST") and alarm.row.reason not in ("excluded", "scale jump", "at fault")
    comes_badly = alarm.code.startswith("SENSOR_DOUBTFUL") and alarm.row.reason in ("slow", "noise")
    is_quality = is_lost or comes_badly or alarm.code == "WINCH_MODEL_UPDATED"
    return bool(blamed_by(read, noise=False)) and not is_quality


@dataclass(frozen=True)
class Named:
    """What a finding may name, in one unit."""

    assumed: float  # assumed at first
    low: float  # least that the truth may be, as far as the readings show it
    high: float  # most that it may be
    noticeable: float  # difference that is just worth naming
    far: float  # difference that is an error whatever the truth is

    def is_wrong(self, learnt: float) -> bool:
        """Return whether a `learnt` value is on the wrong side of the nominal one, or names what is nominal."""
        if self.low == self.high == self.assumed:
            return True
        off = max(self.low - learnt, learnt - self.high)
        if off < self.noticeable:
            return False
        if self.low > self.assumed + self.noticeable:
            return learnt < self.assumed
        if self.high < self.assumed - self.noticeable:
            return learnt > self.assumed
        return off > self.far


NO_POWER_LIMIT = 1e6
"""Power that no winch has [kW]."""


def named_by(assumed: float, low: float, high: float) -> Named:
    """Return what differs in a ratio: 2 % of the belief are worth naming, 10 % are an error in any case."""
    return Named(assumed, low, high, noticeable=0.02 * assumed, far=0.1 * assumed)


def named_things(settings: Settings) -> dict[str, Named]:
    """Return what findings on the winch, MRU and drum may name, by their words, for the truth in `settings`.

    The encoder counts turns of the drum: the gain that it shows is without the error of the radius, and what the MRU
    reads over the payout that holds the unit is with it. A dead zone looks like a lower gain, play in the encoder's
    gear like a longer lag.
    """
    truth = {name.removeprefix("virtual_winch."): value for name, value in settings.items()}
    gain = truth.get("speed_gain", 1.0)
    acceleration, speed = truth.get("acceleration_limit", ACCELERATION), truth.get("speed_limit", SPEED)
    # power over a tension that is not known here: it can be a speed limit of any size
    has_power_limit = truth.get("power_limit", 0.0) > 0.0
    power = 1e-3 * truth["power_limit"] if has_power_limit else NO_POWER_LIMIT

    def limit(assumed: float, true: float, *, may_be_slower: bool = False) -> Named:
        return named_by(assumed, 0.0 if may_be_slower else min(true, assumed), min(true, assumed))

    play = 0.5 * truth.get("encoder.backlash", 0.0) / USUAL_SPEED
    servo, delay = truth.get("time_constant", SERVO), truth.get("command_delay", DELAY)
    scale = (1.0 + settings.get("wave_vessel.mru.scale_error", 0.0)) * (1.0 + truth.get("drum_radius_error", 0.0))
    return {
        "acceleration limit paying out": limit(ACCELERATION, acceleration),
        "acceleration limit hauling in": limit(
            ACCELERATION, acceleration * truth.get("hauling_acceleration_share", 1.0)
        ),
        "speed limit paying out": limit(SPEED, speed, may_be_slower=has_power_limit),
        "speed limit hauling in": limit(
            SPEED, speed * truth.get("hauling_speed_share", 1.0), may_be_slower=has_power_limit
        ),
        "power limit": Named(NO_POWER_LIMIT, power, power, noticeable=0.02 * power, far=0.1 * power),
        "dead zone": Named(0.0, 0.0, truth.get("speed_deadband", 0.0), noticeable=0.01, far=0.02),
        "encoder play": Named(0.0, 0.0, truth.get("encoder.backlash", 0.0), noticeable=3e-3, far=0.01),
        "gain by the encoder": named_by(1.0, gain * (1.0 - truth.get("speed_deadband", 0.0) / USUAL_SPEED), gain),
        "gain of hauling in over that": named_by(1.0, 1.0, 1.0),
        "creep": Named(0.0, 0.0, 0.0, noticeable=0.0, far=0.0),
        # a drum shows their sum: what one has too little the other has too much
        "time constant": Named(SERVO, servo, servo + play, noticeable=0.01, far=0.05),
        "command delay": Named(DELAY, delay, delay + play, noticeable=0.01, far=0.05),
        "mru or drum": named_by(1.0, scale, scale),
    }


def named_values(words: str) -> list[tuple[str, float]]:
    """Return what an alarm names, with the value that was learnt."""
    found = []
    for alarm in alarms_in(words):
        if alarm.code == "WINCH_MODEL_UPDATED":
            found += changes_in(alarm.text)
        elif alarm.code == "IDENTIFIED, MRU":
            found += [("mru or drum", float(value)) for value in re.findall(r"reads (-?[\d.]+) times", alarm.text)]
    return found


def is_wrong(words: str, settings: Settings) -> bool:
    """Return whether an alarm names something that is nominal, or that differs to the other side."""
    things = named_things(settings)
    is_late = settings.get("wave_vessel.mru.stamp_error", 0.0) > 0.0
    is_filtered = settings.get("wave_vessel.mru.high_pass_period", 0.0) > 0.0
    noises = {row: settings.get(name, sigma) / sigma for row, (name, sigma) in NOISE_ROWS.items()}
    wrongs = {
        "mru": not (is_filtered or is_late or named_values(words)),
        "depth": True,
        "encoder": True,
        "cable": not any(settings.get(name, 1.0) != 1.0 for name in (INERTIA, DAMPING, DRAG)),
    }
    is_misnamed = any(things[name].is_wrong(learnt) for name, learnt in named_values(words))
    is_quiet = any(factor < 1.5 for row, factor in noises.items() if f"noise of {row} is" in words)
    suspects = [part for alarm in alarms_in(words) for part in blamed_by(alarm, noise=False)]
    is_blameless = any(wrongs.get(part, False) for part in suspects if "WINCH_MODEL_UPDATED" not in words)
    return is_misnamed or is_quiet or is_blameless


def show(one: Draw, found: Kept) -> str:
    """Return one line of the table, and one for each alarm that is wrong."""
    line = (
        f"{one.name:24s} {100 * found.sigma:6.2f} of {100 * found.off:5.1f} cm, worst minute {found.worst:5.3f} at "
        f"{found.at:3.0f} s, given up {found.fades}, compensates {100 * found.share:3.0f} %, "
        f"{len(found.alarms):2d} findings{'' if found.holds else ' WORSE THAN OFF'}"
    )
    if math.isfinite(found.told):
        verdict = "" if found.is_as_informed else f" MORE THAN {LARGEST_OVER_TOLD:g} TIMES"
        line += f", learnt {100 * found.learnt:.2f} cm, told {100 * found.told:.2f} cm{verdict}"
    return "\n".join([line, *(f"    wrong: {words}" for words in found.wrong)])


def summary(found: Sequence[Kept]) -> str:
    """Return what all draws came to."""
    ratios = np.array([one.worst for one in found])
    shares = ", ".join(f"p{p} {np.percentile(ratios, p):.3f}" for p in (10, 50, 90, 95))
    kept_draws = sum(one.holds for one in found)
    return (
        f"{kept_draws} of {len(found)} never worse than {LARGEST} times off; worst minute {shares}, largest "
        f"{np.max(ratios):.3f}; {sum(one.fades > 0 for one in found)} given up at least once, "
        f"{sum(one.share == 0.0 for one in found)} lost; {sum(bool(one.wrong) for one in found)} with a wrong finding, "
        f"{np.mean([len(one.alarms) for one in found]):.1f} findings a run"
    )


def frame_of(draws: Sequence[Draw], found: Sequence[Kept]) -> pandas.DataFrame:
    """Return a row for each draw, as `influences` takes it: what was drawn, and the efficiency it came to.

    Parameters
    ----------
    draws, found : in one order
    """
    rows = []
    for one, its in zip(draws, found, strict=True):
        drawn = {name: value for name, value in one.settings.items() if value or name not in AS_ASSUMED}
        rows.append({FAILURE: "", NOMINAL: False, **AS_ASSUMED, **drawn, EFFICIENCY: 1.0 - its.sigma / its.off})
    return pandas.DataFrame(rows)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the campaign; return 1 where the promise was broken, a finding is wrong or nothing was compensated."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draws", type=int, default=0, metavar="N", help="so many draws; 0: the plain table")
    parser.add_argument("--plant", action="store_true", help="draw mass, damping and drag of the unit as well")
    parser.add_argument("--first", type=int, default=0, metavar="N", help="number of the first one (default 0)")
    parser.add_argument("--seeds", type=int, default=1, metavar="N", help="seeds of the plain table (default 1)")
    parser.add_argument("--alarms", action="store_true", help="print all findings of each run")
    options = parser.parse_args(arguments)
    drawn = draw_with_plant if options.plant else draw
    draws = [drawn(number) for number in range(options.first, options.first + options.draws)]
    seeds = range(1, options.seeds + 1)
    draws = draws or [Draw(name, seed, PLAIN[name], TOLD.get(name, {})) for name in PLAIN for seed in seeds]
    sys.stdout.write(commit_line() + "\n")
    found = []
    for one in draws:
        found.append(run(one))
        lines = [show(one, found[-1]), *(f"    {words}" for words in found[-1].alarms if options.alarms)]
        sys.stdout.write("\n".join(lines) + "\n")
        sys.stdout.flush()
    sys.stdout.write(summary(found) + "\n")
    if options.draws >= FEWEST_CASES:
        ranked = influences(frame_of(draws, found), EFFICIENCY)
        print_parts([make_table(*influence_rows(ranked, EFFICIENCY), texts=["influence"])])
    return 0 if all(one.is_kept for one in found) else 1


if __name__ == "__main__":
    sys.exit(main())
