"""Budgets of a node's time: what a scenario states, what diagnostics report of it, what is traced."""

import ctypes
import math

import pytest
from heave_node.ros.diagnostics import Level
from heave_node.ros.input_timing import LIBRARY, TickTiming, TickTrace
from heave_node.run_parameters import RunParameters
from heave_node.tick.time_budget import TimeBudget

BUDGETS = ("all=period:0.06", "winch_controller=work:0.005", "winch_controller=period:0.1", "cable_sim=age:0.04")


@pytest.fixture
def clock(monkeypatch):
    now = {"monotonic": 100.0, "thread_time": 5.0}
    monkeypatch.setattr("time.monotonic", lambda: now["monotonic"])
    monkeypatch.setattr("time.thread_time", lambda: now["thread_time"])
    return now


def test_a_node_has_the_budget_of_all_and_its_own_on_top_of_it():
    run = RunParameters(time_budgets=BUDGETS)
    assert run.time_budget_of("winch_controller") == TimeBudget(period=0.1, work=0.005)
    assert run.time_budget_of("cable_sim") == TimeBudget(period=0.06, age=0.04)
    assert RunParameters().time_budget_of("cable_sim") == (math.inf, math.inf, math.inf)


@pytest.mark.parametrize("text", ["cable_sim", "=age:1", "cable_sim=cpu:1", "cable_sim=age:0", "cable_sim=age:much"])
def test_a_budget_that_is_none_is_refused_in_one_line(text):
    with pytest.raises(
        ValueError, match=r"time_budgets: .* must be NODE=QUANTITY:S, QUANTITY one of period, age, work"
    ):
        RunParameters(time_budgets=(text,))


def test_a_budget_of_no_node_is_refused():
    with pytest.raises(ValueError, match=r"time_budgets: winch=age:1: no such node; known: all, recorder, cable_sim"):
        RunParameters(time_budgets=("winch=age:1",))


def stepped(timing, clock, periods, *, work=0.002, age=0.01):
    for period in periods:
        clock["monotonic"] += period
        timing.began()
        clock["thread_time"] += work
        timing.ended(age)
    return {health.part: health for health in timing.diagnose()}


def test_within_its_budget_a_node_reports_what_diagnostic_updater_does(clock):
    timing = TickTiming("probe", TimeBudget(0.06, 0.04, 0.005), 0.05)
    assert timing.diagnose() == []
    reported = stepped(timing, clock, [0.05] * 21)
    assert [health.level for health in reported.values()] == [Level.OK] * 3
    frequency, stamps = reported["Frequency Status"], reported["Timestamp Status"]
    assert frequency.message == "Desired frequency met"
    assert frequency.values["Events in window"] == frequency.values["Events since startup"] == "20"
    assert float(frequency.values["Actual frequency (Hz)"]) == pytest.approx(20.0, rel=1e-6)
    assert float(frequency.values["Target frequency (Hz)"]) == 20.0
    assert float(frequency.values["Minimum acceptable frequency (Hz)"]) == pytest.approx(1.0 / 0.06, rel=1e-6)
    assert stamps.message == "Timestamps are reasonable."
    assert float(stamps.values["Latest timestamp delay:"]) == 0.01
    assert reported["timing work in a tick"].values["count"] == "21"


def test_one_tick_over_budget_is_a_warning_once(clock):
    timing = TickTiming("probe", TimeBudget(0.06, 0.04, 0.005), 0.05)
    stepped(timing, clock, [0.05] * 5)
    stepped_late = stepped(timing, clock, [0.08], work=0.006, age=0.05)
    assert {health.part: (health.level, health.message) for health in stepped_late.values()} == {
        "timing work in a tick": (Level.WARN, "Processor time too long: 6.0 ms, budget 5 ms"),
        "Frequency Status": (Level.WARN, "Frequency too low: 80.0 ms, budget 60 ms"),
        "Timestamp Status": (Level.WARN, "Timestamps too far in past seen: 50.0 ms, budget 40 ms"),
    }
    after = stepped(timing, clock, [0.05] * 5)
    assert [health.level for health in after.values()] == [Level.OK] * 3
    assert after["Timestamp Status"].values["Late diagnostic update count:"] == "1"


def test_the_time_of_a_pause_is_no_period(clock):
    timing = TickTiming("probe", TimeBudget(period=0.06), 0.05)
    stepped(timing, clock, [0.05] * 5)
    timing.broke_off()
    frequency = stepped(timing, clock, [0.5, 0.05])["Frequency Status"]
    assert (frequency.level, frequency.values["Events in window"]) == (Level.OK, "1")


def test_without_a_budget_nothing_is_a_warning(clock):
    reported = stepped(TickTiming("probe", TimeBudget(), 0.05), clock, [0.05, 5.0], work=3.0, age=4.0)
    assert [health.level for health in reported.values()] == [Level.OK] * 3


class Traced:
    """A library that notes its calls."""

    def __init__(self):
        self.calls = []

    def __getattr__(self, name):
        return lambda callback, *_: self.calls.append((name, callback.value))


def test_a_tick_is_traced_as_a_callback_that_is_registered_by_its_node(monkeypatch):
    library = Traced()
    monkeypatch.setattr("ctypes.CDLL", lambda name: library)
    trace = TickTrace("probe")
    trace.began()
    trace.ended()
    names = ["ros_trace_rclcpp_callback_register", "ros_trace_callback_start", "ros_trace_callback_end"]
    assert library.calls == [(name, id(trace)) for name in names]


def test_the_library_of_ros_has_these_points():
    try:
        library = ctypes.CDLL(LIBRARY)
    except OSError:
        pytest.skip(f"{LIBRARY} is not installed: tracetools of ROS 2")
    assert library.ros_trace_rclcpp_callback_register
    assert library.ros_trace_callback_start
    assert library.ros_trace_callback_end


def missing(name):
    raise OSError(name)


@pytest.mark.parametrize("library", [missing, lambda name: object()], ids=["missing", "built without its functions"])
def test_without_the_library_or_its_functions_nothing_is_traced(library, monkeypatch):
    monkeypatch.setattr("ctypes.CDLL", library)
    trace = TickTrace("probe")
    trace.began()
    trace.ended()
