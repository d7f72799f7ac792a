"""Whether readings are as far off what was foreseen as their noise allows."""

import math

from winch_controller_node.estimation.surprise import Surprise
from winch_controller_node.model.estimator import Innovation

DT = 0.05


def test_surprise_lasts_while_innovations_are_larger_than_foreseen():
    surprise = Surprise(DT)
    for _ in range(600):
        surprise.add({"unit_heave": Innovation(0.02, 0.02, 1.0, True)})
    assert (surprise.time, surprise.words) == (0.0, "")
    for _ in range(600):
        surprise.add({"unit_heave": Innovation(0.06, 0.02, 9.0, True), "payout": Innovation(1.0, 1e-3, 1e6, True)})
    assert surprise.worst[0] == "unit_heave"
    # 1 + 8 (1 - exp(-t/20 s)) is above 2 from 2.7 s on
    assert abs(surprise.time - 30.0 - 20.0 * math.log(7.0 / 8.0)) < 0.2
    assert surprise.words
    waited = 0
    while surprise.words and not waited > 1000:
        surprise.add({"unit_heave": Innovation(0.02, 0.02, 1.0, True)})
        waited += 1
    # a mean square of 7.2 falls to 2, with a memory of 20 s, when 1 comes from now on
    assert abs(waited * DT / (20.0 * math.log(6.2)) - 1.0) < 0.02
    for _ in range(600):
        surprise.add({"unit_heave": Innovation(0.06, 0.02, 9.0, True)})
    surprise.restart()
    assert (surprise.time, surprise.words) == (0.0, "")


def test_a_spike_is_no_lasting_error():
    surprise = Surprise(DT)
    for k in range(400):
        surprise.add({"mru_heave": Innovation(0.0, 1.0, 1e9 if k == 200 else 1.0, True)})
        assert not surprise.is_surprised_by("mru_heave")
