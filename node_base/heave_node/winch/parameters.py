"""What plant and controller state alike of a winch: one definition of each value, its range and its default."""

from __future__ import annotations

from dataclasses import dataclass

from heave_node.parameters import parameter


@dataclass(frozen=True)
class WinchFigures:
    """How a winch answers a command, and what it cannot exceed.

    The defaults are the winch of the benchmark scenarios: a speed servo of 0.15 s, 2 m/s, 1.5 m/s^2, a command delay of
    0.2 s.
    """

    law: str = parameter(
        "speed_servo",
        unit="",
        choices=("speed_servo", "first_order"),
        description="speed_servo: v' = (v_set - v)/T; first_order: u' = K (u_0 - u), thesis Eq. 6.1.",
    )
    time_constant: float = parameter(0.15, unit="s", minimum=1e-3, maximum=60.0, description="T of the speed servo.")
    position_rate: float = parameter(
        1.0, unit="1/s", minimum=1e-3, maximum=1e3, description="K of the first-order winch."
    )
    command_delay: float = parameter(
        0.2, unit="s", minimum=0.0, maximum=60.0, description="Time from the start of a command's tick to its effect."
    )
    speed_limit: float = parameter(2.0, unit="m/s", minimum=1e-3, maximum=100.0, description="Largest payout speed.")
    creep: float = parameter(
        0.0,
        unit="m/s",
        minimum=-1.0,
        maximum=1.0,
        description="Speed of a servo at a set-point of 0, added at every other: a load moves a drum whose speed loop "
        "has no integral part; the brake holds all the same.",
    )
    payout_minimum: float = parameter(
        -50.0, unit="m", minimum=-20_000.0, maximum=20_000.0, description="Lower end of the payout range."
    )
    payout_maximum: float = parameter(
        50.0, unit="m", minimum=-20_000.0, maximum=20_000.0, description="Upper end of the payout range."
    )
    power_limit: float = parameter(
        0.0,
        unit="W",
        minimum=0.0,
        maximum=1e9,
        description="Largest product of tension and speed in either direction; 0 means no limit.",
    )
