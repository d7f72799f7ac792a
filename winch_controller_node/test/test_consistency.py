"""Whether readings are as far off what was predicted as their noise allows."""

import math

from winch_controller_node.model.estimator import Innovation

from tests.gates import Consistency

DT = 0.05


def test_inconsistency_lasts_while_innovations_are_larger_than_predicted():
    consistency = Consistency(DT)
    for _ in range(600):
        consistency.add({"unit_heave": Innovation(0.02, 0.02, 1.0, True)})
    assert (consistency.time, consistency.words) == (0.0, "")
    for _ in range(600):
        consistency.add({"unit_heave": Innovation(0.06, 0.02, 9.0, True), "payout": Innovation(1.0, 1e-3, 1e6, True)})
    assert consistency.worst[0] == "unit_heave"
    # 1 + 8 (1 - exp(-t/20 s)) is above 2 from 2.7 s on
    assert abs(consistency.time - 30.0 - 20.0 * math.log(7.0 / 8.0)) < 0.2
    assert consistency.words
    waited = 0
    while consistency.words and not waited > 1000:
        consistency.add({"unit_heave": Innovation(0.02, 0.02, 1.0, True)})
        waited += 1
    # a mean square of 7.2 falls to 2, with a memory of 20 s, when 1 comes from now on
    assert abs(waited * DT / (20.0 * math.log(6.2)) - 1.0) < 0.02
    for _ in range(600):
        consistency.add({"unit_heave": Innovation(0.06, 0.02, 9.0, True)})
    consistency.restart()
    assert (consistency.time, consistency.words) == (0.0, "")


def news_of(consistency, nis, seconds):
    """Return time [s] and alarm of each report while the normalised innovations squared are `nis`."""
    found = []
    for k in range(1, round(seconds / DT) + 1):
        consistency.add({"unit_heave": Innovation(0.0, 1.0, nis, True)})
        found += [(k * DT, alarm) for alarm in consistency.news()]
    return found


def test_readings_that_disagree_and_that_nothing_explains_are_an_alarm_once():
    """1 + 8 (1 - exp(-t/20 s)) is above 2 from 2.7 s on: the alarm comes 90 s later, with sqrt(9) = 3."""
    consistency = Consistency(DT)
    ((time, alarm),) = news_of(consistency, 9.0, 300.0)
    assert abs(time - 90.0 - 20.0 * math.log(8.0 / 7.0)) < 0.2
    assert alarm.name == "SENSORS_DISAGREE"
    assert alarm.values["measurement"] == "unit_heave"
    assert abs(alarm.values["ratio"] - 3.0) < 0.05
    assert news_of(consistency, 1.0, 100.0) == []
    assert len(news_of(consistency, 9.0, 100.0)) == 1, "it is over, and comes back"


def test_an_explanation_within_a_minute_and_a_half_is_no_alarm():
    consistency = Consistency(DT)
    assert news_of(consistency, 9.0, 80.0) == []
    consistency.restart()
    assert consistency.time == 0.0
    assert news_of(consistency, 9.0, 80.0) == []


def test_a_spike_is_no_lasting_error():
    consistency = Consistency(DT)
    for k in range(400):
        consistency.add({"mru_heave": Innovation(0.0, 1.0, 1e9 if k == 200 else 1.0, True)})
        assert not consistency.is_inconsistent("mru_heave")
