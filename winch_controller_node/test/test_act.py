"""The acting half of a tick in the core: what leaves is what was commanded, and nothing is allocated for it."""

import pytest
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario
from heave_core.law_table import ACT_DONE, COMMAND, CONTROLLED, GIVEN, Stage

from tests.allocation import allocates

TICK, ACTED = 0.05, [row.name for row in CONTROLLED.rows].index("acted")


def settled(*changes):
    """Return a loop of 300 m that compensates, after 50 s."""
    given = ["all.duration=200", "all.seed=1", *changes]
    loop = ClosedLoop(loop_parameters(load_scenario("b2_calm_300", settings=given)))
    for _ in range(round(50.0 / TICK)):
        loop.step()
    return loop


def numbers_of(structure, array):
    return dict(zip((row.name for row in structure.rows), array.tolist(), strict=True))


@pytest.mark.parametrize("gain", [0.0, 0.5])
def test_a_drive_makes_the_commanded_speed_of_the_order_wherever_its_payout_is(gain):
    """v = rate + k (payout - u) with u as it is predicted: by both set-points of the tick, and by the mean payout's."""
    loop = settled(f"system.winch.position_gain={gain}")
    command = loop.controller._command
    for _ in range(40):
        outputs, _ = loop.step()
        done, made = numbers_of(ACT_DONE, loop.controller._control.done[ACTED:]), numbers_of(COMMAND, command._numbers)
        order, encoder = outputs.order, loop.controller.observer.encoder
        ahead = encoder.scale * (made["payout"] + encoder.offset)
        assert not done["is_replaced"]
        wanted = made["sent"] - made["standing"]
        assert order.payout_rate + gain * (order.payout - ahead) == pytest.approx(wanted, abs=1e-9)
        assert done["own_rate"] + gain * (done["own_payout"] - made["payout"]) == pytest.approx(wanted, abs=1e-9)
        assert made["value"] == made["compensating"] + made["mean"]


def test_nothing_is_allocated_from_the_readings_to_the_order_that_leaves():
    control = settled().controller._control
    number = [row.name for row in GIVEN.rows].index("number")

    def go():
        control.given[number] += 1.0
        stage = control.go_on(Stage.SENSE)
        while stage:
            stage = control.go_on(stage)

    go()
    assert not allocates(go)
