"""The position loop of a winch: the highest gain with which a drum of bounded acceleration comes to rest.

The loop asks for the speed v = k e where the payout is e away from its set-point. A drum that speeds up at most by a
and runs at most at V comes in at V and begins to brake where k e = V, V/k before its set-point, but needs V^2/(2 a) to
stop. It overshoots by V^2/(2 a) - V/k; the swing before was V^2/(2 a) + V/k, from rest to V and on to where it braked.
Each swing is thus (k V - 2 a)/(k V + 2 a) of the one before: with k = 4 a/V a third, and smaller swings die faster
still. With far more gain the drum swings for minutes, at its acceleration limit all the time.
"""

from __future__ import annotations


def highest_position_gain(speed_limit: float, acceleration_limit: float) -> float:
    """Return the gain [1/s] from payout error to speed with which each swing is a third of the one before: 4 a/V.

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
