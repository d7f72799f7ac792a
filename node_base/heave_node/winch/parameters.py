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

    law: str = parameter("speed_servo",
        description="speed_servo: v' = (v_set - v)/T; first_order: u' = K (u_0 - u), thesis Eq. 6.1.",
        choices=("speed_servo", "first_order"))  # fmt: skip
    time_constant: float = parameter(0.15, "s", 1e-3, 60.0, "T of the speed servo.")
    position_rate: float = parameter(1.0, "1/s", 1e-3, 1e3, "K of the first-order winch.")
    command_delay: float = parameter(0.2, "s", 0.0, 60.0, "Time from the start of a command's tick to its effect.")
    speed_limit: float = parameter(2.0, "m/s", 1e-3, 100.0, "Largest payout speed.")
    acceleration_limit: float = parameter(1.5, "m/s^2", 1e-3, 1e6,
        "Largest payout acceleration in normal operation; of a detailed drive, that of its speed reference.",
    )  # fmt: skip
    speed_gain: float = parameter(1.0, "", 0.1, 10.0, "Speed servo: steady speed divided by the set-point.")
    position_gain: float = parameter(0.0, "1/s", 0.0, 100.0,
        "Gain k_p from payout error to speed; 0: the drive follows the rate set-point only.")  # fmt: skip
    creep: float = parameter(0.0, "m/s", -1.0, 1.0,
        "Drift speed under load of a drum whose speed loop has no integral action; it adds to every "
        "set-point. The brake stops it.")  # fmt: skip
    payout_minimum: float = parameter(-50.0, "m", -20_000.0, 20_000.0, "Lower end of the payout range.")
    payout_maximum: float = parameter(50.0, "m", -20_000.0, 20_000.0, "Upper end of the payout range.")
    power_limit: float = parameter(0.0, "W", 0.0, 1e9,
        "Largest product of tension and speed in either direction; 0: no limit.")  # fmt: skip


def highest_position_gain(speed_limit: float, acceleration_limit: float) -> float:
    """Return the gain [1/s] from payout error to speed with which each swing is a third of the one before: 4 a/V.

    The loop asks for the speed v = k e where the payout is e away from its set-point. A drum that speeds up at most by
    a and runs at most at V comes in at V and begins to brake where k e = V, V/k before its set-point, but needs V^2/(2
    a) to stop. It overshoots by V^2/(2 a) - V/k; the swing before was V^2/(2 a) + V/k, from rest to V and on to where
    it braked. Each swing is thus (k V - 2 a)/(k V + 2 a) of the one before: with k = 4 a/V a third, and smaller swings
    die faster still. With far more gain the drum swings for minutes, at its acceleration limit all the time.

    Parameters
    ----------
    speed_limit : V, largest speed of the drum [m/s]
    acceleration_limit : a, largest acceleration with which it brakes [m/s^2]
    """
    return 4.0 * acceleration_limit / speed_limit


def check_position_gain(name: str, gain: float, speed_limit: float, acceleration_limit: float) -> None:
    """Raise ValueError for a gain with which the drum would swing about its set-point.

    Parameters
    ----------
    name : of the parameter
    gain : from payout error to speed [1/s]
    speed_limit, acceleration_limit : of the drum [m/s], [m/s^2]
    """
    highest = highest_position_gain(speed_limit, acceleration_limit)
    if gain > highest:
        raise ValueError(
            f"{name} = {gain:g} 1/s makes the drum swing about its set-point: with {speed_limit:g} m/s and "
            f"{acceleration_limit:g} m/s^2 it can be {highest:g} 1/s at most"
        )
