"""A stop that an operator asks for leaves the unit as it would swing with the winch locked, whatever the sea."""

import numpy as np
import pytest
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario

from tests.campaigns.promise import TROUBLE, WINDOW, worst_window

TICK = 0.05
LET_GO = 1.1
"""Largest ratio of the unit to the uncompensated one after it: a swing of 5 cm may be left when the brake goes on."""

LONGEST = 61.0
"""Fade-out 10 s, settling 30 s and coming to rest 20 s at most [s]."""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scenario", "law", "seed", "time", "rest"),
    [
        ("b10_real_mru_swell", "mpc", 8763, 138.9, "standby"),  # 2.3 where the brake went on after 10 s
        ("b10_real_mru_swell", "mpc", 4040, 103.4, "standby"),  # 2.1
        ("b4_limit_900_tp8", "mpc", 5210, 145.3, "stopped"),  # 1.5
        ("b3_deep_900", "lqg", 1491, 110.1, "standby"),  # 1.8
        ("b2_calm_300", "lqg", 8693, 110.5, "stopped"),
    ],
)
def test_a_requested_stop_lets_the_unit_go_as_it_would_swing_with_the_winch_locked(scenario, law, seed, time, rest):
    """The sea's period is near that of the free unit: what a stop sets going swings on for minutes."""
    end = time + TROUBLE + WINDOW + 10.0
    changes = [f"winch_controller.law={law}", f"all.seed={seed}", f"all.duration={end}"]
    loop = ClosedLoop(loop_parameters(load_scenario(scenario, settings=changes)))

    def stop(tick, outputs):
        if tick == round(time / TICK):
            loop.controller.set_mode(rest)

    record = loop.run(stop)
    unit, off = record.column("unit") + record.column("depth_set_point"), record.column("uncompensated")
    worst, at = worst_window(record.column("time"), unit, off, time + TROUBLE)
    assert np.isfinite(at)
    assert worst < LET_GO
    stopped = [when for when, mode in zip(record.column("time"), record.modes, strict=True) if mode == rest]
    assert time < next(when for when in stopped if when > time) < time + LONGEST


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scenario", "law", "seed", "mode"),
    [
        # 3.7 cm where the unit was swung up to what noise says of the uncompensated one
        ("b2_calm_300", "mpc", 3, "standby"),
        ("b3_deep_900", "mpc", 3, "stopped"),  # 3.2 cm where the drum came to rest wherever it was
        ("b3_deep_900", "lqg", 4, "emergency_stop"),
    ],
)
def test_no_stop_moves_a_unit_that_is_held_by_more_than_two_centimetres_in_calm_water(scenario, law, seed, mode):
    """Hs is 5 mm: the waves alone move the uncompensated unit by 2 to 5 mm."""
    time = 60.0 + 3.1 * seed
    changes = [f"winch_controller.law={law}", f"all.seed={seed}", f"all.duration={time + WINDOW + TROUBLE}"]
    changes.append("wave_vessel.significant_wave_height=0.005")
    loop = ClosedLoop(loop_parameters(load_scenario(scenario, settings=changes)))
    held = []

    def stop(tick, outputs):
        if tick == round(time / TICK):
            held.append(outputs.report.mode)
            loop.controller.set_mode(mode)

    record = loop.run(stop)
    unit = (record.column("unit") + record.column("depth_set_point"))[round(time / TICK) :]
    assert held == ["compensating"]
    assert record.modes[-1] == mode
    assert np.max(np.abs(unit - unit[0])) < 0.02
