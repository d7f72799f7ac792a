"""Above the highest tension the winch gives way, whatever the law asks, where compensation can keep below it."""

import numpy as np
import pytest
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario
from heave_core.law import LoopNow
from heave_core.law_table import COMMAND_STATE, Way
from heave_core.library import new
from heave_node.parameters import ParameterError
from winch_controller_node.core.loop_command import commander
from winch_controller_node.core.supervision.watch.highest_tension import LEFT, PEAK, HighestTension
from winch_controller_node.design.design import design_controller
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.laws import LimitParameters
from winch_controller_node.parameters.model import WinchModelParameters

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


@pytest.mark.parametrize(("use", "share"), [(0.0, LEFT), (0.8, LEFT), (1.25, 0.2), (4.0, 0.75)])
def test_what_is_beyond_the_winch_is_needed_as_tension(use, share):
    tension = HighestTension(60.0, tick_period=DT)
    for stretch in 0.5 * np.sin(0.6 * DT * np.arange(12000)):
        tension.update(stretch, 3.0, tension_per_metre=0.2, peak_use=use, brake=False)
    sigma = 0.5 / np.sqrt(2.0)
    assert tension.least_ratio(0.2, use) == pytest.approx(1.0 + share * PEAK * sigma * 0.2, rel=0.05)
    assert tension.is_kept
    assert tension.alarm is None


def test_a_highest_tension_that_was_too_low_is_kept_again_after_five_minutes_or_once_the_brake_was_on():
    tension = HighestTension(60.0, tick_period=DT)

    def after(seconds, ratio, *, brake=False):
        for _ in range(round(seconds / DT)):
            tension.update(0.0, ratio, tension_per_metre=0.2, peak_use=0.5, brake=brake)
        return tension.is_kept

    assert not after(DT, 0.9)
    assert not after(299.0, 1.1)
    assert after(2.0, 1.1)
    assert not after(DT, 0.9, brake=True)
    assert after(DT, 1.1, brake=True)


def flat(tension, ratio=3.0, *, stretch=0.0, use=0.5, brake=False):
    tension.update(stretch, ratio, tension_per_metre=0.2, peak_use=use, brake=brake)


def rolling(tension, seconds=240.0, **given):
    """Let the boom tip stretch the cable by 0.5 m to and fro, a period of 10 s."""
    for stretch in 0.5 * np.sin(2.0 * np.pi * 0.1 * DT * np.arange(round(seconds / DT))):
        flat(tension, stretch=stretch, **given)


def test_the_least_that_would_do_is_told_in_hundredths_rounded_up():
    """A tenth of 2.7 sigma, 0.5 / sqrt(2) m of 0.2 a metre: 1.0191, of which 1.01 is too low and 1.02 enough."""
    tension = HighestTension(60.0, tick_period=DT)
    rolling(tension)
    flat(tension, ratio=1.019)
    assert tension.alarm.code == "TENSION_LIMIT_LOW"
    assert "1.02" in tension.alarm.text
    assert not tension.is_kept
    flat(tension, ratio=1.02)
    assert tension.alarm is None


def test_a_highest_tension_that_is_just_what_is_needed_will_do():
    """In a flat sea the static tension itself is enough: nothing is added to it."""
    tension = HighestTension(60.0, tick_period=DT)
    assert tension.is_kept, "before anything was seen"
    flat(tension, ratio=1.0)
    assert tension.alarm is None
    assert tension.is_kept
    assert tension.least_ratio(0.2, 5.0) == 1.0


def test_a_winch_at_rest_and_one_that_follows_the_whole_sea_leave_the_same_share():
    """A peak use of 0 is no division: the share that is left is a tenth, as where half the winch would do."""
    tension = HighestTension(60.0, tick_period=DT)
    rolling(tension)
    assert tension.least_ratio(0.2, 0.0) == tension.least_ratio(0.2, 0.5) > 1.0
    assert tension.least_ratio(0.2, 4.0) - 1.0 == pytest.approx(7.5 * (tension.least_ratio(0.2, 0.0) - 1.0))


def test_five_minutes_count_from_the_last_tick_in_which_it_was_too_low():
    tension = HighestTension(60.0, tick_period=DT)
    flat(tension, ratio=0.9)
    for _ in range(round(200.0 / DT)):
        flat(tension, ratio=1.1)
    flat(tension, ratio=0.9)
    ticks = 0
    while not tension.is_kept:
        flat(tension, ratio=1.1)
        ticks += 1
    assert ticks * DT == pytest.approx(300.0, abs=2.0 * DT)


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
    monkeypatch.setattr(HighestTension, "least_ratio", lambda *_: 1.0)
    record = with_highest_tension("b3_deep_900", 1.01, 110.0).run()
    assert np.max(record.column("top_tension", after=60.0)) > 1.02 * np.median(record.column("top_tension"))
    assert record.unit_sigma(60.0) < 0.05 * record.uncompensated_sigma(60.0)


@pytest.mark.parametrize(("scenario", "ratio"), [("b3_deep_900", 1.02), ("b4_limit_900_tp10", 1.005)])
def test_a_highest_tension_that_compensation_cannot_keep_makes_it_none_the_worse(scenario, ratio):
    record = with_highest_tension(scenario, ratio, 120.0).run()
    assert record.unit_sigma(60.0) < 0.05 * record.uncompensated_sigma(60.0)
    assert [alarm.code for _, alarm in record.alarms].count("TENSION_LIMIT_LOW") == 1
