"""What must hold before the winch follows the sea."""

import re
from types import SimpleNamespace

import pytest
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario
from winch_controller_node.core.supervision.entry_gates import EntryGates
from winch_controller_node.core.supervision.supervisor import Supervisor
from winch_controller_node.laws.parts.winch_limits import WinchLimits
from winch_controller_node.parameters.laws import EntryParameters

DT = 0.05
LIMITS = WinchLimits(2.0, 1.5, -50.0, 50.0)


def gates_over(sigma, **thresholds):
    """Return gates over a boom tip of a standard deviation `sigma` [m]."""
    gates = EntryGates(EntryParameters(**thresholds))
    gates.observe(sigma)
    return gates


def test_constant_tension_waits_for_peaks_below_four_fifths_of_the_limits():
    """A peak is 1.5 significant amplitudes: 0.53 of them make 80 %."""
    gates = gates_over(0.0)
    assert gates.for_tension(0.0, LIMITS, 0.53) == ""
    assert re.findall(r"\d+", gates.for_tension(0.0, LIMITS, 0.6)) == ["90", "80"]


def test_both_modes_need_room_for_the_waves_in_the_range_of_payout():
    gates = gates_over(1.0)
    for payout, room in ((48.0, 2.0), (-48.5, 1.5), (60.0, 0.0)):
        reason = gates.for_compensation(payout, LIMITS, 0.1, 2.0)
        assert [float(one) for one in re.findall(r"-?\d+\.\d", reason)] == [payout, room, 3.0]
        assert gates.for_tension(payout, LIMITS, 0.1) == reason
    assert gates.for_compensation(46.5, LIMITS, 0.1, 2.0) == ""
    assert gates.for_tension(-46.5, LIMITS, 0.1) == ""


def test_compensation_waits_until_it_is_predicted_to_leave_no_more_than_is_allowed():
    gates = gates_over(0.0)
    assert gates.for_compensation(0.0, LIMITS, 0.9, 0.9) == ""
    assert re.findall(r"[\d.]+", gates.for_compensation(0.0, LIMITS, 0.95, 0.9)) == ["95", "90"]


def test_peaks_above_four_fifths_of_the_limits_are_told_with_the_share_that_compensation_begins_with():
    gates = gates_over(0.0)
    assert gates.peaks_alarm(0.53, 1.0) is None
    within, beyond = gates.peaks_alarm(0.6, 0.85), gates.peaks_alarm(0.8, 1.0)
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


def test_all_gates_that_are_closed_are_told():
    words = gates_over(1.0).for_tension(49.0, LIMITS, 2.0)
    assert words.startswith("a payout of 49.0 m leaves 1.0 m")
    room, peaks = words.split("; ")
    assert [float(one) for one in re.findall(r"\d+\.\d", room)] == [49.0, 1.0, 3.0]
    assert re.findall(r"\d+", peaks) == ["300", "80"]


def test_compensation_waits_for_waves_and_for_readings_that_can_be_believed():
    """60 s of twice the settling time: in calm water none come, and it begins without them."""
    gates = SimpleNamespace(for_compensation=lambda *_: "the sea demands too much")
    supervisor = SimpleNamespace(
        _dt=DT,
        _parameters=SimpleNamespace(modes=SimpleNamespace(settling_time=30.0)),
        _gates=gates,
        _limits=LIMITS,
        guard=SimpleNamespace(residual=0.1, largest_residual=0.9),
        highest_tension=SimpleNamespace(alarm=None),
        _standing=SimpleNamespace(gate=""),
    )

    def words(time, *, knows_sea, inconsistency=""):
        tick = SimpleNamespace(number=round(time / DT), knows_sea=knows_sea, inconsistency=inconsistency)
        return Supervisor._closed_gates(supervisor, tick, 0.0)

    assert words(20.0, knows_sea=False) == "measuring the sea, at most 40 s more"
    assert words(60.0, knows_sea=False) == words(20.0, knows_sea=True) == "the sea demands too much"
    assert words(20.0, knows_sea=True, inconsistency="the depth is inconsistent") == "the depth is inconsistent"
