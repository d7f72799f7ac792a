"""An adviser as a program of its own, which takes its time: python adviser_program.py SHORTEST LONGEST.

It answers what the suite's adviser answers, after a wall time between the two [s].
"""

import random
import sys
import time

from heave_node.ros.process import run_node
from winch_controller_node.adviser_node import WinchAdviserNode

SHORTEST, LONGEST = map(float, sys.argv[1:3])


class Unhurried(WinchAdviserNode):
    """Takes its time."""

    @classmethod
    def make_adviser(cls, nominal, tick_period):
        """Return the suite's adviser with a pause before each answer."""
        adviser = super().make_adviser(nominal, tick_period)
        answer, chance = adviser.advise, random.Random()

        def advise(observations):
            time.sleep(chance.uniform(SHORTEST, LONGEST))
            return answer(observations)

        adviser.advise = advise
        return adviser


if __name__ == "__main__":
    sys.exit(run_node(Unhurried))
