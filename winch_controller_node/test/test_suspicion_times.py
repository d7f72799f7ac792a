"""When the sensors are looked at: by how long readings have been foreseen badly, and since when one is doubted."""

import pytest
from winch_controller_node.estimation.reading_record import Surprise
from winch_controller_node.identification.suspicion_times import SuspicionTimes
from winch_controller_node.model.estimator import Innovation

DT = 0.05


def looks(seconds, nis, *, doubted=lambda now: False, trusted=True, knows_winch=lambda now: True):
    """Return the times at which to look [s], and which of them are early, of readings whose innovations are `nis`.

    Parameters
    ----------
    seconds : how long it goes on
    nis, doubted, knows_winch : functions of time [s]
    trusted : the guard trusts the estimate
    """
    times, surprise, found = SuspicionTimes(DT), Surprise(DT), []
    for tick in range(round(seconds / DT)):
        now = tick * DT
        surprise.add({"unit_heave": Innovation(0.0, 1.0, nis(now), accepted=True)})
        times.pass_tick(tick, surprise, is_doubted=doubted(now))
        if times.is_due(tick, surprise, is_doubted=doubted(now), is_trusted=trusted, knows_winch=knows_winch(now)):
            found.append((now, times.is_early))
    return found, times.onset * DT


def surprised_from(begin, size):
    return lambda now: size if now >= begin else 1.0


def test_readings_that_are_as_foreseen_are_never_looked_into():
    assert looks(200.0, lambda now: 1.0)[0] == []


def test_readings_that_are_foreseen_badly_are_looked_into_after_half_a_minute_and_then_ever_more_seldom():
    """A mean of 4 with a memory of 20 s is 2 after 20 log(3/2) = 8.1 s; next after 30 s, 60 s."""
    found, onset = looks(200.0, surprised_from(50.0, 4.0))
    assert onset == pytest.approx(58.1, abs=0.2)
    assert [now for now, _ in found] == pytest.approx([88.1, 118.1, 178.1], abs=0.3)
    assert not any(is_early for _, is_early in found)


def test_readings_that_are_foreseen_very_badly_are_looked_into_once_before():
    """The mean of 20 is 2 after 1.1 s and 6 long before 10 s have passed."""
    found, _ = looks(85.0, surprised_from(50.0, 20.0))
    assert [now for now, _ in found] == pytest.approx([61.1, 81.1], abs=0.3)


@pytest.mark.parametrize(("known_from", "looked_at"), [(0.0, 88.1), (95.0, 95.0), (300.0, 118.1)])
def test_while_the_winch_does_not_do_what_is_believed_sensors_wait_for_at_most_a_minute(known_from, looked_at):
    found, _ = looks(119.0, surprised_from(50.0, 4.0), knows_winch=lambda now: now >= known_from)
    assert found[0][0] == pytest.approx(looked_at, abs=0.3)


def test_where_the_estimate_is_not_trusted_sensors_are_looked_into_every_five_seconds():
    found, _ = looks(20.0, lambda now: 1.0, trusted=False)
    assert [now for now, _ in found] == pytest.approx([0.0, 5.0, 10.0, 15.0], abs=DT)


def test_a_sensor_that_is_doubted_may_be_explained_from_half_a_minute_on_and_is_judged_every_minute():
    """Doubted from 50 s on: early looks once 30 s have passed since the onset, each 10 s, for 70 s at most."""
    found, _ = looks(175.0, lambda now: 1.0, doubted=lambda now: now >= 50.0)
    assert [(round(now), is_early) for now, is_early in found] == [
        (80, True),
        (90, True),
        (100, True),
        (110, True),
        (110, False),
        (170, False),
    ]
