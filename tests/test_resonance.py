"""A locked unit in resonance: it moves by metres, and compensation begins and holds it still all the same.

The seas have their peak near the axial resonance of a 12 t unit on 1,500 m of wire, at 6.7 s: quadratic drag is then
several times what it is for the small motion that a design is made for.
"""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from heave_bringup.closed_loop import ClosedLoop, LoopRecord, loop_parameters
from heave_bringup.scenarios import load_scenario
from winch_controller_node.interface.readings import Outputs

from tests.campaigns.promise import is_suspicion

BEGINS = 30.0
"""Compensation begins within so long [s]: `modes.settling_time`, or as soon as two waves have been seen."""

LARGEST_SHARE = 0.05
"""Standard deviation of the unit over that of the locked one that is left at most, 25 s after the beginning."""


def loop_in(
    height: float, period: float, *, seed: int = 1, duration: float, belief: tuple[str, ...] = ()
) -> ClosedLoop:
    """Return the loop in a sea of a significant wave `height` [m] and peak `period` [s]; `belief` may be wrong."""
    settings = [
        f"system.sea.significant_wave_height={height!r}",
        f"system.sea.peak_period={period!r}",
        f"all.duration={duration!r}",
        "all.transient=30.0",
        f"all.seed={seed}",
        *belief,
    ]
    return ClosedLoop(loop_parameters(load_scenario("unit_1500", settings=settings)))


def begin_of_compensation(record: LoopRecord, *, after: float = 0.0) -> float:
    """Return when compensation begins [s], `after` a time [s]; infinity where it does not."""
    time = record.column("time")
    compensates = (np.array(record.modes) == "compensating") & (time > after)
    return float(time[np.argmax(compensates)]) if np.any(compensates) else np.inf


def share_left(record: LoopRecord, after: float) -> float:
    """Return the standard deviation of the unit over that of the locked one, `after` a time [s]."""
    return record.unit_sigma(after) / record.uncompensated_sigma(after)


def assert_held(record: LoopRecord) -> None:
    """Check that compensation begins in time, blames nothing, and leaves little."""
    begin = begin_of_compensation(record)
    assert begin < BEGINS, record.alarms
    assert share_left(record, begin + 25.0) < LARGEST_SHARE
    assert not [alarm for _, alarm in record.alarms if is_suspicion(alarm) or alarm.code.startswith("NOISE_LOW")]


def test_compensation_begins_while_the_locked_unit_moves_by_metres():
    record = loop_in(3.0, 10.0, duration=60.0).run()
    assert_held(record)


def test_a_unit_that_an_emergency_stop_sets_swinging_is_compensated_again():
    stop, again = 35.0, 39.0
    loop = loop_in(3.0, 8.0, duration=65.0)

    def on_tick(number: int, _: Outputs) -> None:
        if number == round(stop / 0.05):
            loop.controller.set_mode("emergency_stop")
        if number == round(again / 0.05):
            loop.controller.set_mode("standby")
            loop.controller.set_mode("compensating")

    record = loop.run(on_tick)
    assert begin_of_compensation(record, after=again) < again + 10.0, record.alarms
    assert share_left(record, 55.0) < LARGEST_SHARE


@pytest.mark.long
@pytest.mark.parametrize(
    ("height", "period", "seed"), list(itertools.product((1.5, 3.0, 4.0), (7.0, 8.0, 10.0, 12.0, 14.0), (1, 2)))
)
def test_compensation_begins_near_resonance_in_every_sea(height, period, seed):
    assert_held(loop_in(height, period, seed=seed, duration=110.0).run())


@pytest.mark.long
@pytest.mark.parametrize("length", [3000.0, 4000.0])
def test_a_unit_that_swings_above_its_resonance_is_held_on_a_cable_heavier_than_itself(length):
    """Of 3 t on 3,000 m of cable of 11 t, the waves are at twice the frequency of the first resonance."""
    settings = [f"system.length={length!r}", "all.duration=150", "all.transient=30.0"]
    record = ClosedLoop(loop_parameters(load_scenario("b2_calm_300", settings=settings))).run()
    begin = begin_of_compensation(record)
    assert begin < BEGINS, record.alarms
    assert share_left(record, begin + 40.0) < 0.12
