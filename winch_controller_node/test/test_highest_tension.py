"""Above the highest tension the winch gives way, whatever the law asks, where compensation can keep below it."""

import math

import numpy as np
import pytest
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario
from heave_core.law import LoopNow
from heave_core.law_table import COMMAND_STATE, Way
from heave_core.library import new
from heave_node.parameters import ParameterError
from winch_controller_node.core.loop_command import commander
from winch_controller_node.core.supervision import supervision_design
from winch_controller_node.core.supervision.modes import Mode
from winch_controller_node.core.supervision.supervision_design import PEAK_OVER_SIGNIFICANT
from winch_controller_node.core.supervision.supervision_design import TENSION_LEFT as LEFT
from winch_controller_node.core.supervision.supervision_design import TENSION_PEAK as PEAK
from winch_controller_node.design.design import design_controller
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.laws import LimitParameters
from winch_controller_node.parameters.model import WinchModelParameters

from tests.supervised import Supervised

DT = 0.05
RATIO = 1.2


def given_way(excess, *, brake=False, **winch):
    """Return the command and the excess over stiffness [m] for a tension so much [N] above the highest one."""
    parameters = WinchControllerParameters(
        law="lqg",
        limits=LimitParameters(maximum_tension_ratio=RATIO),
        winch=WinchModelParameters(**winch),
    )
    design = design_controller(parameters, tick_period=DT)
    law = design.make_law()
    core = commander(design, law.winch, law, new(COMMAND_STATE))
    tension = RATIO * design.cable.static_tension + excess
    core.act(LoopNow(Way.BY_BRAKE if brake else Way.BY_PLACE, filtered_tension=tension, gives_way=True))
    return core.made, excess / design.cable.stiffness


def test_the_winch_pays_out_the_excess_within_a_second():
    asked, stretch = given_way(5e3)
    assert asked.asked == pytest.approx(stretch / 1.0)
    assert asked.gives_way


def test_a_slow_winch_takes_twice_its_lag():
    asked, stretch = given_way(5e3, command_delay=0.4, time_constant=0.5)
    assert asked.asked == pytest.approx(stretch / 1.8)


def test_nothing_is_added_below_the_highest_tension_or_under_a_brake():
    for made, _ in (given_way(-1.0), given_way(5e3, brake=True)):
        assert made.asked == 0.0
        assert not made.gives_way


class Limited(Supervised):
    """A winch with a highest tension over a cable of 0.2 of the static tension a metre."""

    def __init__(self):
        super().__init__()
        self._limit = self.supervisor._design
        self._limit["tension_per_metre"] = 0.2
        self.supervisor.guard.core.design["acceleration"] = 1e9

    def feed(self, seconds, ratio, *, stretch=0.0, use=0.5, brake=False):
        """Let the boom tip stretch the cable to and fro, a period of 10 s; tell whether the highest tension is kept."""
        for tick in range(round(seconds / DT)):
            self._limit["highest_ratio"] = ratio
            self.enter(Mode.STANDBY if brake else Mode.COMPENSATING, wants=not brake)
            # what the sea demands is as the rate makes it: one of the speed that the use of peaks asks for
            self.supervisor.guard.core.design["usual_speed"] = 1.0 / (use / PEAK_OVER_SIGNIFICANT) if use else math.inf
            self.step(tip=stretch * math.sin(2.0 * math.pi * 0.1 * DT * tick), tip_rate=1.0 if tick % 2 else -1.0)
        return self.is_kept

    @property
    def is_kept(self):
        return bool(self.supervisor._state["is_kept"][0])

    @property
    def is_low(self):
        return bool(self.supervisor._state["is_low"][0])

    @property
    def least_ratio(self):
        return float(self.supervisor._state["least_ratio"][0])


@pytest.mark.parametrize(("use", "share"), [(0.0, LEFT), (0.8, LEFT), (1.25, 0.2), (4.0, 0.75)])
def test_what_is_beyond_the_winch_is_needed_as_tension(use, share):
    winch = Limited()
    assert winch.feed(600.0, 3.0, stretch=0.5, use=use)
    sigma = 0.5 / np.sqrt(2.0)
    assert winch.least_ratio == pytest.approx(1.0 + share * PEAK * sigma * 0.2, rel=0.05)
    assert not winch.is_low


def test_a_highest_tension_that_was_too_low_is_kept_again_after_five_minutes_or_once_the_brake_was_on():
    winch = Limited()
    assert not winch.feed(DT, 0.9)
    assert not winch.feed(299.0, 1.1)
    assert winch.feed(2.0, 1.1)
    assert not winch.feed(DT, 0.9, brake=True)
    assert winch.feed(DT, 1.1, brake=True)


def test_the_least_that_would_do_is_told_in_hundredths_rounded_up():
    """A tenth of 2.7 sigma, 0.5 / sqrt(2) m of 0.2 a metre: 1.0191, of which 1.01 is too low and 1.02 enough."""
    winch = Limited()
    winch.feed(240.0, 3.0, stretch=0.5)
    winch.feed(DT, 1.019)
    assert winch.is_low and not winch.is_kept
    assert winch.supervisor._tension_alarm.code == "TENSION_LIMIT_LOW"
    assert "1.02" in winch.supervisor._tension_alarm.text
    winch.feed(DT, 1.02)
    assert not winch.is_low


def test_a_highest_tension_that_is_just_what_is_needed_will_do():
    """In a flat sea the static tension itself is enough: nothing is added to it."""
    winch = Limited()
    assert winch.is_kept, "before anything was seen"
    assert winch.feed(DT, 1.0)
    assert not winch.is_low
    assert winch.least_ratio == 1.0


def test_five_minutes_count_from_the_last_tick_in_which_it_was_too_low():
    winch = Limited()
    winch.feed(DT, 0.9)
    winch.feed(200.0, 1.1)
    winch.feed(DT, 0.9)
    assert not winch.feed(299.9, 1.1)
    assert winch.feed(0.2, 1.1)


def with_highest_tension(scenario, ratio, duration):
    settings = [f"winch_controller.limits.maximum_tension_ratio={ratio}", f"all.duration={duration}"]
    return ClosedLoop(loop_parameters(load_scenario(scenario, settings=settings)))


@pytest.mark.parametrize("ratio", [0.001, 0.9, 0.9999])
def test_a_highest_tension_below_the_static_one_is_refused_before_anything_starts(ratio):
    setting = f"winch_controller.limits.maximum_tension_ratio={ratio}"
    with pytest.raises(ParameterError) as refusal:
        load_scenario("b2_calm_300", settings=[setting])
    words = f"winch_controller with --set {setting}: limits.maximum_tension_ratio = {ratio} can never be kept"
    assert words in str(refusal.value)
    assert "give more than 1, such as 1.5, or 0 for no highest tension" in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_a_highest_tension_that_waves_exceed_is_refused_at_entry_with_the_least_that_would_do():
    loop = with_highest_tension("b2_calm_300", 1.0, 60.0)
    assert set(loop.run().modes) == {"standby"}
    assert "needs 1.02 times the static tension" in loop.controller.modes.obstacle
    assert "limit 1 times" in loop.controller.modes.obstacle


def test_giving_way_does_not_ring_with_the_wire(monkeypatch):
    """A winch that gave way to the tension as it is read rang with 900 m of wire at 0.9 Hz: 124 of 28 cm."""
    monkeypatch.setattr(supervision_design, "TENSION_PEAK", 0.0)
    record = with_highest_tension("b3_deep_900", 1.01, 110.0).run()
    assert np.max(record.column("top_tension", after=60.0)) > 1.02 * np.median(record.column("top_tension"))
    assert record.unit_sigma(60.0) < 0.05 * record.uncompensated_sigma(60.0)


@pytest.mark.parametrize(("scenario", "ratio"), [("b3_deep_900", 1.02), ("b4_limit_900_tp10", 1.005)])
def test_a_highest_tension_that_compensation_cannot_keep_makes_it_none_the_worse(scenario, ratio):
    record = with_highest_tension(scenario, ratio, 120.0).run()
    assert record.unit_sigma(60.0) < 0.05 * record.uncompensated_sigma(60.0)
    assert [alarm.name for _, alarm in record.alarms].count("TENSION_LIMIT_LOW") == 1
