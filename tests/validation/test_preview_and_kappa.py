"""What a preview of the boom tip is worth: kappa against its length, in a storm that takes the winch to its limits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario
from heave_node import kpi
from heave_studies.kappa import bounds_of

TIMES = (0.0, 1.0, 2.0, 4.0, 8.0)
AFTER = 100.0
NOISE = 0.05
"""Error of the preview [m]."""


def kappa(scenario_name: str, preview_time: float) -> float:
    """Return kappa of a run of 260 s on ten segments."""
    changes = (
        "cable_sim.segments=10",
        f"wave_vessel.preview.time={preview_time}",
        f"wave_vessel.preview.noise={NOISE}",
        f"winch_controller.mpc.preview_time={preview_time}",
    )
    scenario = load_scenario(scenario_name, settings=changes)
    parameters = replace(loop_parameters(scenario), duration=260.0)
    record = ClosedLoop(parameters).run()
    bounds = bounds_of(scenario, record.column("boom_tip", after=AFTER), parameters.tick_period)
    return kpi.kappa(record.unit_sigma(AFTER), *bounds)


def cost(preview_time: float) -> tuple[float, float]:
    """Return what law mpc minimises away from the limits, and the winch's acceleration [m/s^2], of a run of 200 s."""
    changes = (
        "cable_sim.segments=10",
        f"wave_vessel.preview.time={preview_time}",
        "wave_vessel.preview.noise=0.001",
        "winch_controller.mpc.preview_noise=0.001",
        f"winch_controller.mpc.preview_time={preview_time}",
    )
    parameters = replace(loop_parameters(load_scenario("b4_limit_900_tp10", settings=changes)), duration=200.0)
    commands: list[float] = []
    record = ClosedLoop(parameters).run(lambda _, outputs: commands.append(outputs.order.payout_rate))
    law, judged = parameters.controller.mpc, record.column("time") >= AFTER
    acceleration = float(np.sqrt(np.mean(np.square(record.column("payout_acceleration", after=AFTER)))))
    command = float(np.sqrt(np.mean(np.square(np.array(commands)[judged]))))
    shares = (
        record.unit_sigma(AFTER) / law.unit_heave,
        acceleration / law.free_payout_acceleration,
        command / law.free_command,
    )
    return float(np.sum(np.square(shares))), acceleration


@pytest.mark.long
@pytest.mark.timeout(3600)
def test_where_the_winch_is_strong_enough_a_preview_lowers_the_cost_and_spares_the_winch() -> None:
    """A linear-quadratic regulator that knows more has a lower cost; the unit's motion is a part of that."""
    (without, harder), (with_preview, softer) = cost(0.0), cost(4.0)
    assert with_preview < 0.95 * without
    assert softer < harder


@pytest.mark.long
@pytest.mark.timeout(3600)
def test_in_a_storm_a_preview_of_some_seconds_is_worth_a_third_of_the_motion() -> None:
    """The plan begins in time what the winch is too slow for. The bounds know the future, or the sensors alone."""
    found = [kappa("b5_storm", time) for time in TIMES]
    assert found[TIMES.index(2.0)] < found[0] * 2.0 / 3.0
    assert found[-1] <= found[TIMES.index(2.0)]
