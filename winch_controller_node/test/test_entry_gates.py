"""What must hold before the winch follows the sea."""

import itertools
import math
import re

import pytest
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario
from winch_controller_node.core.supervision.modes import Mode
from winch_controller_node.core.supervision.supervisor import peaks_alarm, peaks_words, range_words
from winch_controller_node.laws.parts.winch_limits import WinchLimits

from tests.supervised import Supervised

DT = 0.05
LIMITS = WinchLimits(2.0, 1.5, -50.0, 50.0)


def standby(*, sigma=0.0, demand=0.0, seconds=100.0, wants=True, **given):
    """Return a braked winch with a range of 50 m below a boom tip that heaves by a `sigma` [m].

    Its speed is such that the sea demands so much of it.
    """
    loop = Supervised(mode=Mode.STANDBY, wants=wants)
    loop.supervisor._design["payout_minimum"], loop.supervisor._design["payout_maximum"] = -50.0, 50.0
    loop.supervisor._limits = LIMITS
    design = loop.supervisor.guard.core.design
    design["acceleration"], design["usual_speed"] = 1e9, 1.0 / demand if demand else 1e9
    for tick in range(round(seconds / DT)):
        wave = math.sin(1.0 * tick * DT)
        loop.enter(Mode.STANDBY, wants=False)
        loop.step(tip=math.sqrt(2.0) * sigma * wave, tip_rate=wave if demand else 0.0, tension_time=1e3, **given)
    return loop


def closed(loop, **winch):
    """Return what keeps compensation, and constant tension, from beginning with such a winch, in words."""
    loop.enter(Mode.STANDBY, wants=False)
    loop.supervisor._design["hanging"] = 1.0
    loop.step(winch=winch, tension_time=1e3)
    now = loop.supervisor.modes._look()
    return now.gates, now.tension


def test_constant_tension_waits_for_peaks_below_four_fifths_of_the_limits():
    """A peak is 1.5 significant amplitudes: 0.53 of them make 80 %."""
    assert closed(standby(demand=0.52))[1] == ""
    (peak, most) = re.findall(r"\d+", closed(standby(demand=0.6))[1])
    assert (float(peak), float(most)) == (pytest.approx(90.0, abs=2.0), 80.0)
    assert re.findall(r"\d+", peaks_words(0.9, 0.8)) == ["90", "80"]


def test_both_modes_need_room_for_the_waves_in_the_range_of_payout():
    loop = standby(sigma=1.0)
    for payout, room in ((48.0, 2.0), (-48.5, 1.5), (60.0, 0.0)):
        reasons = closed(loop, mean_payout=payout)
        for reason in reasons:
            assert [float(one) for one in re.findall(r"-?\d+\.\d", reason)][:2] == [payout, room]
    assert closed(loop, mean_payout=46.5) == closed(loop, mean_payout=-46.5) == ("", "")
    assert [float(one) for one in re.findall(r"-?\d+\.\d", range_words(48.0, LIMITS, 1.0))] == [48.0, 2.0, 3.0]


def test_compensation_waits_until_it_is_predicted_to_leave_no_more_than_is_allowed():
    """Of an unknown gain V = 1/share - 1 the best authority leaves sqrt(V / (1 + V)) of the motion: sqrt(1 - share)."""
    loop = standby()
    assert closed(loop, share=0.2)[0] == ""
    assert re.findall(r"[\d.]+", closed(loop, share=0.0975)[0]) == ["95", "90"]


def test_peaks_above_four_fifths_of_the_limits_are_told_with_the_share_that_compensation_begins_with():
    assert peaks_alarm(0.795, 0.8, 1.0) is peaks_alarm(math.nan, 0.8, 1.0) is None
    within, beyond = peaks_alarm(0.9, 0.8, 0.85), peaks_alarm(1.2, 0.8, 1.0)
    assert within.code == beyond.code == "SEA_ABOVE_WINCH"
    figures = [[alarm.values[name] for name in ("percent", "limit", "authority")] for alarm in (within, beyond)]
    assert figures == [pytest.approx([90.0, 80.0, 85.0]), pytest.approx([120.0, 80.0, 100.0])]
    assert [bool(alarm.values["rest"]) for alarm in (within, beyond)] == [False, True]


@pytest.mark.parametrize(("law", "share"), [("mpc", 100), ("lqg", 100), ("industrial", 78)])
def test_compensation_that_begins_in_a_sea_beyond_the_winch_says_by_how_much_and_with_what_share(law, share):
    """Benchmark B4 with its period of 10 s: laws that plan take all of the sea, one that does not 85 over 109 of it."""
    settings = ["all.duration=30", "wave_vessel.ramp=5", f"winch_controller.law={law}"]
    record = ClosedLoop(loop_parameters(load_scenario("b4_limit_900_tp10", settings=settings))).run()
    alarms = [alarm for _, alarm in record.alarms]
    at = next(at for at, alarm in enumerate(alarms) if alarm.values.get("mode") == "compensating")
    told = alarms[at + 1]
    assert told.code == "SEA_ABOVE_WINCH"
    assert told.values["percent"] > 80.0
    assert told.values["authority"] == pytest.approx(share, abs=1.0)


def test_a_sea_that_rises_while_the_winch_follows_it_is_told_again_by_what_it_has_come_to():
    """Compensation begins at 20 s, a third up the ramp of a sea that needs more than the winch has."""
    settings = ["all.duration=120", "wave_vessel.ramp=60"]
    record = ClosedLoop(loop_parameters(load_scenario("b4_limit_900_tp10", settings=settings))).run()
    told = [alarm.values["percent"] for _, alarm in record.alarms if alarm.name == "SEA_ABOVE_WINCH"]
    assert told[0] < 100.0 <= told[-1]
    assert all(after > 1.5 * before for before, after in itertools.pairwise(told))


def test_all_gates_that_are_closed_are_told():
    room, peaks = closed(standby(sigma=1.0, demand=2.0), mean_payout=49.0)[1].split("; ")
    assert room.startswith("a payout of 49.0 m leaves 1.0 m")
    assert re.findall(r"\d+", peaks)[1] == "80"


def test_compensation_waits_for_waves_and_for_readings_that_can_be_believed():
    """60 s of twice the settling time: in calm water none come, and it begins without them."""
    loop = Supervised(mode=Mode.STANDBY)
    loop.supervisor._design["longest_wait"] = 60.0

    def words(time, **given):
        loop.number = round(time / DT) - 1
        loop.enter(Mode.STANDBY, wants=False)
        loop.step(tension_time=1e3, winch={"is_reversed": False}, **given)
        return loop.supervisor.modes._look().gates

    assert words(20.0, knows_sea=0) == "measuring the sea, at most 40 s more"
    assert words(60.0, knows_sea=0) == words(20.0) == ""
    assert words(20.0, disagree_time=1.0) == "the depth is inconsistent"
