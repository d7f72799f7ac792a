"""The depth sensor is lost during a move: how the unit trails the drum is known all the same."""

import numpy as np
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario

MOVES, LOST, END = 40.0, 46.0, 48.0


def test_a_move_goes_on_without_a_jerk_where_the_depth_sensor_is_lost():
    """125 t on 900 m trail 4 m of rope by a third of a metre: none of it is to be made up for, seen or unseen."""
    settings = [
        f"all.duration={END}",
        "all.transient=30",
        "system.sea.significant_wave_height=0.1",
        f"winch_controller.programme.move_times=[{MOVES}]",
        "winch_controller.programme.move_payouts=[4.0]",
        *(f"cable_sim.sensors.depth.faults.{key}" for key in ("kind=[gap]", f"start=[{LOST}]", "duration=[30.0]")),
        "cable_sim.sensors.depth.faults.magnitude=[0.0]",
    ]
    loop = ClosedLoop(loop_parameters(load_scenario("b3_deep_900", settings=settings)))
    rates = []
    loop.run(lambda tick, outputs: rates.append(outputs.order.payout_rate))
    assert loop.controller.observer.gates["depth"].is_lost
    after = np.array(rates[round(LOST / 0.05) :])
    assert np.abs(after).max() < 0.7, "1.5 m/s where the bound of what is unseen took the known swing for an error"
