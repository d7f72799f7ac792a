"""Whether readings are as far off what was predicted as their noise allows."""

import math

from winch_controller_node.estimation.surprise import Surprise
from winch_controller_node.model.estimator import Innovation

DT = 0.05


def test_surprise_lasts_while_innovations_are_larger_than_predicted():
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


def news_of(surprise, nis, seconds):
    """Return time [s] and alarm of each report while the normalised innovations squared are `nis`."""
    found = []
    for k in range(1, round(seconds / DT) + 1):
        surprise.add({"unit_heave": Innovation(0.0, 1.0, nis, True)})
        found += [(k * DT, alarm) for alarm in surprise.news()]
    return found


def test_readings_that_disagree_and_that_nothing_explains_are_an_alarm_once():
    """1 + 8 (1 - exp(-t/20 s)) is above 2 from 2.7 s on: the alarm comes 90 s later, with sqrt(9) = 3."""
    surprise = Surprise(DT)
    ((time, alarm),) = news_of(surprise, 9.0, 300.0)
    assert abs(time - 90.0 - 20.0 * math.log(8.0 / 7.0)) < 0.2
    assert alarm.code == "SENSORS_DISAGREE"
    assert alarm.values["measurement"] == "unit_heave"
    assert abs(alarm.values["ratio"] - 3.0) < 0.05
    assert news_of(surprise, 1.0, 100.0) == []
    assert len(news_of(surprise, 9.0, 100.0)) == 1, "it is over, and comes back"


def test_an_explanation_within_a_minute_and_a_half_is_no_alarm():
    surprise = Surprise(DT)
    assert news_of(surprise, 9.0, 80.0) == []
    surprise.restart()
    assert surprise.time == 0.0
    assert news_of(surprise, 9.0, 80.0) == []


def test_a_spike_is_no_lasting_error():
    surprise = Surprise(DT)
    for k in range(400):
        surprise.add({"mru_heave": Innovation(0.0, 1.0, 1e9 if k == 200 else 1.0, True)})
        assert not surprise.is_surprised_by("mru_heave")
