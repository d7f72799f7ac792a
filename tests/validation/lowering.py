"""A plant that is lowered at a steady speed while its top moves."""

import numpy as np


def lower(plant, motion, speed, stop, tick):
    """Lower a plant at rest at `speed` [m/s], reached in 5 s, to a length `stop` [m]; `motion` is its top's, by time.

    Return, at the end of each tick, lengths [m] and positions of the unit [m].
    """
    lengths, units, payout, rate = [], [], 0.0, 0.0
    for k in range(int((stop - plant.unstretched_length) / speed / tick)):
        new = speed * min((k + 1) * tick / 5.0, 1.0)
        after = payout + 0.5 * tick * (rate + new)
        plant.advance(tick, motion(k * tick), motion((k + 1) * tick), payout, rate, after, new)
        payout, rate = after, new
        lengths.append(plant.unstretched_length)
        units.append(plant.unit_position)
    return np.array(lengths), np.array(units)
