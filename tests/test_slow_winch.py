"""A winch that is several times slower, or goes farther or less far, than the controller assumes."""

import numpy as np
import pytest
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario

from tests.campaigns.promise import is_suspicion, worst_window


def run(scenario, *settings):
    """Return the record of a run and what is assumed at its end, by quantity."""
    loop = ClosedLoop(loop_parameters(load_scenario(scenario, settings=settings)))
    record = loop.run()
    return record, {name: belief.value for name, belief in loop.controller.beliefs.values.items()}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scenario", "law", "name", "value", "seed"),
    [
        ("b3_deep_900", "mpc", "time_constant", 1.0, 3),
        ("b3_deep_900", "mpc", "time_constant", 0.4, 3),
        ("b2_calm_300", "lqg", "time_constant", 0.6, 4),
        ("b3_deep_900", "mpc", "speed_gain", 0.4, 5),
    ],
)
def test_a_winch_that_is_several_times_off_is_known_within_half_a_minute_and_holds_the_unit(
    scenario, law, name, value, seed
):
    """It was reported with limits that no winch had, and left half of the motion, or all of it."""
    settings = [f"virtual_winch.{name}={value}", f"winch_controller.law={law}", f"all.seed={seed}", "all.duration=150"]
    record, assumed = run(scenario, *settings)
    begins = next(time for time, words in record.alarms if words.values.get("mode") == "compensating")
    time = record.column("time")
    after = time > begins + 45.0
    unit, off = (record.column(motion)[after] for motion in ("unit", "uncompensated"))
    assert np.std(unit) < 0.1 * np.std(off)
    assert assumed[f"winch.{name}"] == pytest.approx(value, rel=0.03)
    # nothing else is: servo and delay are found together, and are as they were but for 10 ms
    others = {"winch.time_constant": 0.15, "winch.command_delay": 0.2, "winch.speed_gain": 1.0}
    assert {q: v for q, v in assumed.items() if q != f"winch.{name}" and not q.startswith("sea.")} == {
        q: pytest.approx(v, abs=0.01) for q, v in others.items() if q in assumed and q != f"winch.{name}"
    }
    told = [time for time, alarm in record.alarms if is_suspicion(alarm) or alarm.name.endswith("_MODEL_UPDATED")]
    assert told
    assert told[0] < begins + 30.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("time_constant", "seed", "duration"),
    [
        (1.0, 3, 130),  # it still goes the one way while it is already sent the other
        (1.5, 7, 270),  # at 265 s it hardly moves, and how it moved before is most of what it still does
    ],
)
def test_a_winch_that_is_known_to_be_slow_blames_no_encoder(time_constant, seed, duration):
    """Of 1 s, as published winches have, and more."""
    settings = [f"system.winch.time_constant={time_constant}", f"all.seed={seed}", f"all.duration={duration}"]
    record = ClosedLoop(loop_parameters(load_scenario("b3_deep_900", settings=settings))).run()
    assert [alarm.values for _, alarm in record.alarms] == [{"mode": "compensating", "reason": "estimate settled"}]
    after = record.column("time") > 60.0
    assert np.std(record.column("unit")[after]) < 0.05 * np.std(record.column("uncompensated")[after])


@pytest.mark.long
def test_a_slow_winch_in_a_high_sea_is_sent_no_more_than_it_takes_and_holds_the_unit():
    """At the limits of a servo of 1.5 s the set-point is far ahead of the speed, and ends at the speed limit: plans
    that did not know left the unit worse than off (2.7, against 1 with the winch known).
    """
    changes = ["virtual_winch.time_constant=1.5", "all.duration=200"]
    record = ClosedLoop(loop_parameters(load_scenario("b4_limit_900_tp10", settings=changes))).run()
    unit, off = record.column("unit") + record.column("depth_set_point"), record.column("uncompensated")
    worst, at = worst_window(record.column("time"), unit, off, 60.0)
    assert np.isfinite(at)
    assert worst < 0.3
    assert set(record.modes[1200:]) == {"compensating"}


@pytest.mark.slow
def test_a_winch_that_is_slow_and_weak_is_known_as_it_is_in_a_high_sea():
    """Both at once, servo ten times slower and half of the limits, were reported as a quarter of them and half of the
    gain, the fade-out after it moved the drum by 2 m, and the brake left a swing 2.3 times that without compensation.
    """
    true = {"time_constant": 1.5, "speed_limit": 1.0, "acceleration_limit": 0.75, "stop_deceleration": 0.7}
    settings = [f"virtual_winch.{name}={value}" for name, value in true.items()]
    settings += ["all.seed=7", "all.duration=180"]
    record, assumed = run("b4_limit_900_tp10", *settings)
    unit, off = record.column("unit") + record.column("depth_set_point"), record.column("uncompensated")
    worst, at = worst_window(record.column("time"), unit, off, 55.0)
    assert np.isfinite(at)
    assert worst < 0.6
    assert assumed["winch.time_constant"] == pytest.approx(1.5, rel=0.02)
    # of both directions where both were reached
    for limit, true in (("speed", 1.0), ("acceleration", 0.75)):
        found = [value for name, value in assumed.items() if name.startswith(f"winch.{limit}_")]
        assert found
        assert found == pytest.approx([true] * len(found), rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "time_constant"), [(2, 0.6), (5, 0.15), (1, 0.6)])
def test_law_lqg_is_no_worse_than_off_on_a_winch_with_a_sixth_of_the_power_that_the_sea_asks_for(seed, time_constant):
    """Seed 2 left 1.118 times the uncompensated motion over a minute.

    25 kW are 0.2 m/s; benchmark B4 at 10 s asks for 1.2 m/s. Law mpc leaves 0.91 of it at most.
    """
    settings = ["winch_controller.law=lqg", "virtual_winch.power_limit=25000", f"all.seed={seed}", "all.duration=270"]
    settings.append(f"virtual_winch.time_constant={time_constant}")
    record = ClosedLoop(loop_parameters(load_scenario("b4_limit_900_tp10", settings=settings))).run()
    unit = record.column("unit") + record.column("depth_set_point")
    ratio, _ = worst_window(record.column("time"), unit, record.column("uncompensated"), 60.0)
    assert ratio < 0.95
    assert "fade_out" not in {alarm.values.get("mode") for _, alarm in record.alarms}


@pytest.mark.slow
@pytest.mark.parametrize(
    "winch",
    [
        ["winch_controller.law=mpc", "system.winch.speed_limit=0.2"],
        ["winch_controller.law=lqg", "virtual_winch.hauling_speed_share=0.1", "virtual_winch.time_constant=0.8"],
    ],
)
def test_a_winch_with_a_seventh_of_the_speed_is_no_worse_than_off_where_the_cable_goes_slack(winch):
    """They left 1.16 and 1.18: the unit was held to what a unit of another natural period does without compensation."""
    settings = ["all.seed=341", "all.duration=270", *winch]
    record = ClosedLoop(loop_parameters(load_scenario("b4_limit_900_tp10", settings=settings))).run()
    unit = record.column("unit") + record.column("depth_set_point")
    ratio, at = worst_window(record.column("time"), unit, record.column("uncompensated"), 60.0)
    assert np.isfinite(at)
    assert ratio < 1.05


@pytest.mark.slow
def test_the_encoder_of_a_winch_at_its_limits_is_not_blamed():
    """At a limit that is known it reads half of what is sent, all at once."""
    settings = ["winch_controller.law=lqg", "all.seed=7786", "all.duration=300"]
    settings += ["virtual_winch.speed_gain=0.49", "virtual_winch.hauling_speed_share=0.3"]
    record, assumed = run("b2_calm_300", *settings)
    unit = record.column("unit") + record.column("depth_set_point")
    ratio, at = worst_window(record.column("time"), unit, record.column("uncompensated"), 65.0)
    assert np.isfinite(at)
    assert ratio < 0.2
    assert not [alarm for _, alarm in record.alarms if is_suspicion(alarm)]
    assert assumed["winch.speed_in"] == pytest.approx(0.6, rel=0.05)


@pytest.mark.slow
def test_harm_by_a_gain_is_no_reason_to_wait_once_the_gain_is_known():
    """The gain is 2.7: it was learnt too late for the second try, and the third had to wait for minutes."""
    settings = ["all.seed=1633", "all.duration=240", "virtual_winch.speed_gain=2.7", "virtual_winch.command_delay=0.3"]
    record, assumed = run("b3_deep_900", *settings)
    assert assumed["winch.speed_gain"] == pytest.approx(2.7, rel=0.02)
    late = record.column("time") > 140.0
    assert all(mode == "compensating" for mode, is_late in zip(record.modes, late, strict=True) if is_late)
    assert np.std(record.column("unit")[late]) < 0.1 * np.std(record.column("uncompensated")[late])
