"""Time of one controller step at 20 Hz, law by law, in the closed loop of a scenario without ROS."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario
from winch_controller_node.interface.readings import Measurements, Outputs

SCENARIO = "b4_limit_900_tp10"
"""A sea in which the limits act all the time: the constrained law at its hardest."""
LAWS = ("lqg", "feedforward", "mpc")
WARM_UP = 60.0
"""Simulated time before the first step that counts [s]."""


def measure_controller(duration: float, say: Callable[[str], None]) -> list[dict[str, object]]:
    """Measure the controller's step under each law.

    Parameters
    ----------
    duration : simulated time of each measurement [s]
    say : called with what is being measured

    Returns `law`, `step_p50_s`, `step_p99_s`, `step_max_s` and `steps` for each law.
    """
    return [_measure(law, duration, say) for law in LAWS]


def _measure(law: str, duration: float, say: Callable[[str], None]) -> dict[str, object]:
    say(f"controller: {law}, {duration:g} s of {SCENARIO}")
    settings = (f"winch_controller.law={law}", f"all.duration={WARM_UP + duration}")
    scenario = load_scenario(SCENARIO, settings=settings)
    loop = ClosedLoop(loop_parameters(scenario))
    times: list[float] = []
    step = loop.controller.step

    def timed_step(tick: int, measurements: Measurements) -> Outputs:
        began = time.perf_counter()
        outputs = step(tick, measurements)
        times.append(time.perf_counter() - began)
        return outputs

    loop.controller.step = timed_step  # type: ignore[method-assign]  # the loop itself must stay as it is
    loop.run()
    counted = np.array(times[round(WARM_UP / scenario.run.tick_period) :])
    p50, p99 = np.percentile(counted, [50, 99])
    return {
        "law": law,
        "step_p50_s": float(p50),
        "step_p99_s": float(p99),
        "step_max_s": float(counted.max()),
        "steps": int(counted.size),
    }
