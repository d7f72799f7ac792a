"""A sensor that turns while the loop compensates is found, excluded, and trusted again; the unit is at rest meanwhile.

Truth and belief are those of benchmark B3 but for the sensor; an uncompensated unit is what a locked winch leaves.
"""

import dataclasses

import numpy as np
import pytest
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario
from heave_node.interface.codes import SensorLevel
from heave_node.kpi import window_ratios

TICK = 0.05
TURNS, WELL_AGAIN, END = 70.0, 140.0, 290.0
CONTRADICTS = "contradicts all others"


def loop_with(sensor, factor):
    """Return a loop in which a sensor reads a multiple of the heave for a while."""
    loop = ClosedLoop(loop_parameters(load_scenario("b3_deep_900", settings=[f"all.duration={END}"])))
    step = loop.controller.step
    zero = []

    def turned(tick, measured):
        if not TURNS <= tick * TICK < WELL_AGAIN:
            return step(tick, measured)
        if sensor == "mru":
            mru = tuple(m._replace(heave=factor * m.heave, heave_rate=factor * m.heave_rate) for m in measured.mru)
            return step(tick, dataclasses.replace(measured, mru=mru))
        depths = measured.of("depth")
        zero.extend(reading.value for reading in depths[:1])
        wrong = tuple(reading._replace(value=zero[0] + factor * (reading.value - zero[0])) for reading in depths)
        return step(tick, dataclasses.replace(measured, scalar={**measured.scalar, "depth": wrong}))

    loop.controller.step = turned
    return loop


class Run:
    """A run: its record, and in each tick how a sensor is seen, which is excluded, and what is assumed.

    Attributes
    ----------
    record : of the loop
    seen : level and reason of the `sensor` in each tick
    excluded : sensor that is not used, in each tick
    assumed : assumed values other than nominal in each tick, by quantity
    """

    def __init__(self, loop, sensor=""):
        self.seen, self.excluded, self.assumed = [], [], []

        def note(_, outputs):
            self.seen.append(seen_of(outputs, sensor) if sensor else None)
            self.excluded.append(loop.controller.observer.excluded)
            self.assumed.append({name: belief.value for name, belief in loop.controller.beliefs.values.items()})

        self.record = loop.run(note)

    def first(self, owner, after=0.0):
        """Return the first time after another [s] at which something is assumed of an `owner`, or it is excluded."""
        for tick in range(round(after / TICK), len(self.excluded)):
            if self.excluded[tick] == owner or any(name.startswith(f"{owner}.") for name in self.assumed[tick]):
                return tick * TICK
        return np.inf


def seen_of(outputs, sensor):
    """Return how a `sensor` is seen in the report of a tick: level and reason."""
    return next((state.level, state.reason) for state in outputs.report.sensors if state.sensor == sensor)


def told(record, code):
    """Return the times at which an alarm of a `code` was raised [s]."""
    return [time for time, alarm in record.alarms if alarm.name == code]


@pytest.mark.parametrize(
    ("scenario", "mean", "seed"), [("b3_deep_900", 0.12, 2), ("b3_deep_900", 0.3, 1), ("b2_calm_300", 2.65, 1)]
)
def test_a_mean_of_the_heave_as_by_trim_is_found_and_the_unit_held_as_without_it(scenario, mean, seed):
    """It was taken for a long swell: b3 with 0.3 m was 1.7 times worse off, the others were never compensated."""
    fault = {"kind": ["jump"], "start": [0.0], "duration": [0.0], "magnitude": [mean]}
    settings = [f"wave_vessel.mru.faults.{name}={value}" for name, value in fault.items()]
    scenario = load_scenario(scenario, settings=["all.duration=160", f"all.seed={seed}", *settings])
    run = Run(ClosedLoop(loop_parameters(scenario)))
    record = run.record
    # 12 cm for half a minute may as well be a long swell
    assert run.first("mru") < 100.0
    assert run.first("depth") == run.first("encoder") == np.inf
    assert run.assumed[-1]["mru.offset"] == pytest.approx(mean, abs=0.04)
    time, unit, off = (record.column(name) for name in ("time", "unit", "uncompensated"))
    late = time > 110.0
    # benchmarks B2 and B3: 1 cm of 25 to 40
    assert np.std(unit[late]) < 0.04 * np.std(off[late])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scenario", "law", "amplitude", "period"),
    [
        ("b2_calm_300", "lqg", 0.3, 60.0),
        pytest.param("b3_deep_900", "mpc", 0.4, 90.0, marks=pytest.mark.long),
        pytest.param("b10_real_mru_swell", "mpc", 0.5, 120.0, marks=pytest.mark.long),
    ],
)
def test_a_heave_and_its_rate_that_wander_as_in_a_turn_are_told_and_taken_off(scenario, law, amplitude, period):
    """Up to 4.5 times the uncompensated motion was left (b10), and the depth sensor blamed."""
    settings = ["all.duration=260", f"winch_controller.law={law}"]
    loop = ClosedLoop(loop_parameters(load_scenario(scenario, settings=settings)))
    step, frequency, begin = loop.controller.step, 2.0 * np.pi / period, 60.0

    def wandering(reading):
        phase = frequency * max(reading.time - begin, 0.0)
        rate = frequency * amplitude * np.cos(phase) if reading.time > begin else 0.0
        return reading._replace(heave=reading.heave + amplitude * np.sin(phase), heave_rate=reading.heave_rate + rate)

    loop.controller.step = lambda tick, measured: step(
        tick, dataclasses.replace(measured, mru=tuple(map(wandering, measured.mru)))
    )
    run = Run(loop)
    record = run.record
    assert begin < run.first("mru") < begin + 30.0
    assert run.first("depth") == np.inf
    unit = record.column("unit") + record.column("depth_set_point")
    _, ratios = window_ratios(record.column("time"), unit, record.column("uncompensated"), 50.0)
    assert max(ratios) < 0.9


def check_used_again(run, sensor):
    """Check that at the end of a `run` a `sensor` that is right again is used as it is, and the unit held."""
    assert run.excluded[-1] == ""
    assert run.assumed[-1].get(f"{sensor}.scale", 1.0) == pytest.approx(1.0, rel=0.03)
    assert run.record.modes[-1] == "compensating"
    assert run.record.unit_sigma(END - 30.0) < 0.05 * run.record.uncompensated_sigma(END - 30.0)
    assert run.seen[-1] == (SensorLevel.OK, "")


def test_compensation_goes_on_without_a_depth_sensor_that_lies_and_with_it_once_it_is_right():
    """Above a unit that is held still it reads noise, and its sign is not seen: fed back, it swings the unit up slowly.

    It is known once that is above three times its noise of 2 cm, long before the unit moves as much as uncompensated.
    """
    run = Run(loop_with("depth", -1.0), "depth")
    time, unit, off = (run.record.column(name) for name in ("time", "unit", "uncompensated"))
    blind = (time > TURNS) & (time < WELL_AGAIN)
    assert np.std(unit[blind]) < 0.5 * np.std(off[blind])
    assert all(run.first(part) == np.inf for part in ("mru", "encoder", "cable"))
    assert set(run.record.modes[round(TURNS / TICK) :]) == {"compensating"}
    assert run.record.unit_sigma(TURNS) < 0.25 * run.record.uncompensated_sigma(TURNS)
    check_used_again(run, "depth")


def test_an_mru_that_turns_over_is_named_within_20_seconds_harms_nothing_and_is_used_again_once_it_is_right():
    """An MRU that is turned over may jump as well: what is lost is neither used nor blamed."""
    run = Run(loop_with("mru", -1.0), "mru")
    lost = next(iter(told(run.record, "SENSOR_LOST, MRU: jump")), np.inf)
    assert TURNS < min(run.first("mru"), lost) < TURNS + 20.0
    for other in ("depth", "encoder", "cable"):
        assert run.first(other) == np.inf, other
    left_out = [seen for seen, excluded in zip(run.seen, run.excluded, strict=True) if excluded == "mru"]
    assert {level for level, _ in left_out} <= {SensorLevel.SUSPECT, SensorLevel.LOST}
    assert not left_out or (SensorLevel.SUSPECT, CONTRADICTS) in left_out
    # never worse than with a locked winch; 20 s are less than the promise's 30 s
    time, unit, off = (run.record.column(name) for name in ("time", "unit", "uncompensated"))
    blind = (time > TURNS + 20.0) & (time < WELL_AGAIN)
    assert np.std(unit[blind]) < 1.05 * np.std(off[blind])
    check_used_again(run, "mru")


def test_an_operator_who_asks_has_a_sensor_used_again_that_was_left_out():
    loop = loop_with("depth", -1.0)
    loop.controller.observer.exclude("depth")
    loop.controller.set_mode("compensating")
    outputs, _ = loop.step()
    assert seen_of(outputs, "depth") == (SensorLevel.OK, "")
