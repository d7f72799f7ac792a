"""`python -m heave_bringup.compiled`: compile what a run computes with, once after installation, on two processors.

It needs neither ROS nor messages.
"""

from __future__ import annotations

import multiprocessing
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from heave_bringup.closed_loop import LoopParameters

TICKS = 60
"""Of the whole loop: by then every sensor has been read, and the adviser has been asked."""


def main() -> None:
    """Compile plant and controller beside each other, which share nothing; then what only the whole loop calls."""
    other = multiprocessing.get_context("spawn").Process(target=_step_controller)
    other.start()
    _step_plant()
    other.join()
    from heave_bringup.closed_loop import ClosedLoop  # noqa: PLC0415 - the other process needs no plant

    loop = ClosedLoop(_loop_parameters())
    for _ in range(TICKS):
        loop.step()


def _loop_parameters() -> LoopParameters:
    from heave_bringup.closed_loop import loop_parameters  # noqa: PLC0415
    from heave_bringup.scenarios import load_scenario  # noqa: PLC0415

    return loop_parameters(load_scenario("b2_calm_300"))


def _step_plant() -> None:
    from cable_sim_node.component import CableSim  # noqa: PLC0415
    from wave_vessel_node.component import WaveVessel  # noqa: PLC0415

    loop = _loop_parameters()
    sea = WaveVessel(loop.sea, seed=loop.seed, tick_period=loop.tick_period)
    plant = CableSim(loop.plant, seed=loop.seed, tick_period=loop.tick_period)
    vessel = sea.step(1)
    plant.readings(1)
    plant.set_waves(sea.waves())
    plant.advance(1, vessel.boom_tip, (0.0, 0.0), 0.0)


def _step_controller() -> None:
    from winch_controller_node.adviser.component import Adviser  # noqa: PLC0415
    from winch_controller_node.core.component import WinchController  # noqa: PLC0415
    from winch_controller_node.interface.readings import Measurements  # noqa: PLC0415

    loop = _loop_parameters()
    Adviser(loop.controller, tick_period=loop.tick_period)
    controller = WinchController(loop.controller, tick_period=loop.tick_period, seed=loop.seed)
    controller.step(1, Measurements())


if __name__ == "__main__":
    main()
