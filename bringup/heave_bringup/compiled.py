"""`python -m heave_bringup.compiled`: compile the plant, once after installation. It needs neither ROS nor messages."""

from __future__ import annotations

from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario

TICKS = 60
"""Of the whole loop: by then every sensor has been read, and the adviser has been asked."""


def main() -> None:
    """Step a loop, which compiles what it calls."""
    loop = ClosedLoop(loop_parameters(load_scenario("b2_calm_300")))
    for _ in range(TICKS):
        loop.step()


if __name__ == "__main__":
    main()
