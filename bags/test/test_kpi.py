"""The KPI formulas against closed forms."""

import math
from itertools import pairwise

import numpy as np
import pytest
from heave_bags.analyse import kpi_set
from heave_bags.analyse.kpi_set import shown
from heave_bags.signals import RunSignals, Signal
from heave_node import kpi
from heave_node.interface.codes import WinchLimit
from heave_node.loads.strength import strengths
from hypothesis import given
from hypothesis import strategies as st

TIME = np.arange(0.0, 200.0, 0.05)
OMEGA = 2.0 * math.pi / 10.0


def sine(amplitude: float, phase: float = 0.0, mean: float = 0.0) -> np.ndarray:
    return mean + amplitude * np.sin(OMEGA * TIME + phase)


def run(**signals: np.ndarray) -> RunSignals:
    return RunSignals(**{name: Signal(TIME, value) for name, value in signals.items()})


def test_sigma_of_a_sine_over_whole_periods_is_amplitude_over_root_two():
    assert kpi.sigma(sine(2.0, mean=-300.0)) == pytest.approx(2.0 / math.sqrt(2.0), rel=1e-12)


def test_efficiencies_of_sines_are_one_minus_the_amplitude_ratio():
    values = kpi_set.evaluate(
        run(unit_heave=sine(0.1), uncompensated_heave=sine(1.0), boom_tip_heave=sine(1.0), payout=sine(0.95))
    )
    assert values["unit_efficiency"] == pytest.approx(0.9)
    assert values["outlet_efficiency"] == pytest.approx(0.95)
    assert values["significant_residual_m"] == pytest.approx(4.0 * 0.1 / math.sqrt(2.0))


def test_safety_factors_are_capacity_over_the_largest_load_of_the_part_and_unknown_where_none_is_stated():
    pull = run(tension=sine(1e5, mean=4e5), uncompensated_tension=sine(2e5, mean=4e5), unit_tension=sine(5e4, mean=2e5))
    assert math.isnan(kpi_set.evaluate(pull)["rope_safety_factor"])
    plant = {"cable.breaking_force": 1e6, "unit.attachment_breaking_force": 5e5}
    pull.strengths = strengths(plant, {"rated_pull": 4e5})
    values = kpi_set.evaluate(pull)
    assert values["rope_safety_factor"] == pytest.approx(1e6 / 5e5)
    assert values["uncompensated_rope_safety_factor"] == pytest.approx(1e6 / 6e5)
    assert values["winch_pull_factor"] == pytest.approx(4e5 / 5e5)
    assert values["attachment_safety_factor"] == pytest.approx(5e5 / 2.5e5)


def test_the_worst_minute_is_that_of_the_largest_ratio_and_calm_water_counts_as_two_centimetres():
    """Windows of 60 s hold six whole waves: from 70 s to 130 s the unit moves 1.5 times as far as uncompensated."""
    unit = np.where((TIME >= 70.0) & (TIME <= 130.0), sine(0.3), sine(0.02))
    assert kpi_set.evaluate(run(unit_heave=unit, uncompensated_heave=sine(0.2)))["worst_minute"] == pytest.approx(
        1.5, rel=0.01
    )
    calm = kpi_set.evaluate(run(unit_heave=sine(0.01), uncompensated_heave=sine(0.001)))
    assert calm["worst_minute"] == pytest.approx(0.01 / math.sqrt(2.0) / 0.02, rel=0.01)
    short = kpi_set.evaluate(run(unit_heave=unit, uncompensated_heave=unit), start=0.0, end=59.0)
    assert math.isnan(short["worst_minute"])


def test_a_compensator_that_doubles_the_motion_has_efficiency_minus_one():
    assert kpi.efficiency(2.0, 1.0) == -1.0


def test_what_nobody_recorded_is_nan_and_null_never_a_number():
    values = kpi_set.evaluate(RunSignals())
    assert all(math.isnan(value) for value in values.values())
    assert set(kpi_set.to_json(values).values()) == {None}


def test_the_json_keys_that_others_rely_on_exist():
    keys = (
        "unit_sigma_m uncompensated_sigma_m unit_efficiency outlet_efficiency significant_residual_m max_abs_heave_m "
        "kappa tension_min_n tension_max_n slack_percent snaps winch_speed_max_mps winch_acceleration_max_mps2 "
        "time_at_limit_percent power_peak_w energy_wh_per_h real_time_factor loop_age_p99_s missed_deadlines "
        "unit_heave_amplitude_m unit_heave_phase_deg top_tension_mean_n top_tension_amplitude_n"
    )
    assert set(keys.split()) <= set(kpi_set.DEFINITION_OF)


def test_the_largest_tick_counts_once_in_a_thousand():
    """Of 1001 ticks in rising order the one at 99.9 % is the last but one."""
    signals = RunSignals()
    signals.execution_time = Signal(np.arange(1001.0), 1e-3 * np.arange(1001.0))
    values = kpi_set.evaluate(signals)
    assert values["controller_tick_p999_s"] == pytest.approx(0.999)
    assert values["controller_tick_max_s"] == pytest.approx(1.0)


def test_the_window_leaves_the_transient_out():
    heave = np.where(TIME < 100.0, 50.0, sine(0.1))
    values = kpi_set.evaluate(run(unit_heave=heave), start=100.0, end=199.95)
    assert values["unit_sigma_m"] == pytest.approx(0.1 / math.sqrt(2.0), rel=1e-9)


@given(
    mean=st.floats(-1e3, 1e3),
    amplitude=st.floats(0.01, 10.0),
    phase=st.floats(-3.0, 3.0),
    cycles=st.floats(1.1, 30.0),
)
def test_the_first_harmonic_of_a_pure_sine_is_found_exactly_over_any_length(mean, amplitude, phase, cycles):
    time = np.linspace(7.0, 7.0 + cycles * 10.0, 500)
    fit = kpi.fit_harmonic(time, mean + amplitude * np.sin(OMEGA * time + phase), OMEGA)
    assert fit.mean == pytest.approx(mean, abs=1e-7)
    assert fit.amplitude == pytest.approx(amplitude, abs=1e-7)
    assert math.remainder(fit.phase - phase, 2 * math.pi) == pytest.approx(0.0, abs=1e-5)


def test_a_fit_over_less_than_a_period_is_refused():
    with pytest.raises(ValueError, match="at least one period, 10 s"):
        kpi.fit_harmonic(TIME[:100], TIME[:100], OMEGA)


def test_driven_kpis_give_amplitude_lead_and_tension():
    signals = run(
        unit_heave=sine(1.05, phase=-0.2, mean=-300.0), boom_tip_heave=sine(1.0), tension=sine(760.0, mean=3e4)
    )
    signals.driving_omega = OMEGA
    values = kpi_set.evaluate(signals)
    assert values["unit_heave_amplitude_m"] == pytest.approx(1.05)
    assert values["unit_heave_phase_deg"] == pytest.approx(math.degrees(-0.2))
    assert values["top_tension_mean_n"] == pytest.approx(3e4)
    assert values["top_tension_amplitude_n"] == pytest.approx(760.0)


def test_power_of_opposed_sines_is_half_the_product_and_all_regeneration_when_in_phase():
    power = kpi.winch_power(np.full(TIME.size, 5e4), sine(0.5))
    assert power.peak == pytest.approx(2.5e4, rel=1e-4)
    assert power.mean_abs == pytest.approx(2.5e4 * 2.0 / math.pi, rel=1e-4)
    assert power.motoring == pytest.approx(power.regenerated, rel=1e-3)


def test_the_root_mean_square_of_a_sine_of_power_is_its_peak_over_root_two():
    power = kpi.winch_power(np.full(TIME.size, 5e4), sine(0.5))
    assert power.rms == pytest.approx(2.5e4 / math.sqrt(2.0), rel=1e-12)


def test_wear_of_a_sine_is_four_amplitudes_two_turns_and_one_bend_a_period():
    # 20 periods of 10 s; the record begins in the middle of a stroke and ends a sample short of the last
    wear = kpi.rope_wear(TIME, sine(0.5, mean=100.0))
    assert wear.travel == pytest.approx(4.0 * 0.5 * 360.0, rel=1e-3)
    assert wear.reversals == pytest.approx(2.0 * 360.0, rel=1e-3)
    assert wear.bending_cycles == pytest.approx(360.0, rel=1e-3)


def test_only_the_piece_of_rope_at_the_sheave_is_bent_again_and_again():
    # lowering by 40 m at 0.2 m/s bends each piece once; under a heave of 0.5 m in 10 s, whose speed is 0.31 m/s, some
    # rope comes back once in each wave and passes the sheave a second time, never a third
    assert kpi.rope_wear(TIME, 0.2 * TIME).bending_cycles * TIME[-1] / 3600.0 == pytest.approx(1.0)
    wear = kpi.rope_wear(TIME, sine(0.5) + 0.2 * TIME)
    assert wear.bending_cycles * TIME[-1] / 3600.0 == pytest.approx(2.0)


def test_the_ripple_of_an_encoder_does_not_bend_the_rope():
    ripple = 0.001 * (-1.0) ** np.arange(TIME.size)
    wear = kpi.rope_wear(TIME, sine(0.5) + ripple)
    assert wear.bending_cycles == pytest.approx(360.0, rel=0.06)
    assert kpi.rope_wear(TIME, ripple).bending_cycles == 0.0


@given(st.lists(st.integers(-5, 5), min_size=2, max_size=40))
def test_bending_cycles_are_the_level_crossing_count_of_the_most_crossed_level(levels):
    # ASTM E1049, 5.1: count rising crossings of levels between the turning points; one step here is 100 plays
    values = np.array(levels, dtype=float)
    rises = [sum(a < level < b for a, b in pairwise(values)) for level in np.arange(-5.5, 6.0)]
    wear = kpi.rope_wear(np.arange(values.size) * 3600.0 / (values.size - 1), values)
    assert wear.bending_cycles == pytest.approx(max(rises))


def test_cycles_of_tension_and_time_at_high_load_of_a_run_of_sines():
    tension = sine(2e4, -0.5 * math.pi, mean=1e5)  # from a trough to a trough
    signals = run(tension=tension, payout_rate=sine(1.0), payout=sine(1.0))
    signals.speed_limit = 2.0 / math.sqrt(3.0)  # half of it is exceeded from 35.26 deg to 144.74 deg
    values = kpi_set.evaluate(signals)
    assert values["tension_cycles_per_h"] == pytest.approx(360.0, rel=0.01)
    assert values["tension_range_equivalent_n"] == pytest.approx(4e4 / 10.0**0.25, rel=0.01)
    share = 100.0 * (1.0 - 2.0 * math.asin(1.0 / math.sqrt(3.0)) / math.pi)
    assert values["time_above_half_rating_percent"] == pytest.approx(share, abs=1.0)
    signals.power_limit = 1e3
    assert kpi_set.evaluate(signals)["time_above_half_rating_percent"] > 95.0
    signals.speed_limit = signals.power_limit = math.inf
    assert math.isnan(kpi_set.evaluate(signals)["time_above_half_rating_percent"])


def test_a_snap_needs_low_then_high_tension_within_two_seconds():
    time = np.arange(8) * 1.0
    static = 100.0
    taut_in_time = [100, 5, 140, 150, 100, 100, 100, 100]
    too_late = [100, 5, 100, 100, 140, 100, 100, 100]
    twice = [100, 5, 140, 5, 140, 100, 100, 100]
    wrong_order = [140, 5, 100, 100, 100, 100, 100, 100]
    found = [kpi.snap_times(time, tension, static).tolist() for tension in (taut_in_time, too_late, twice, wrong_order)]
    assert found == [[2.0], [], [2.0, 4.0], []]


def test_tension_is_judged_against_the_static_one_of_its_own_time():
    static = Signal(np.array([0.0, 200.0]), np.array([50e3, 100e3]))
    at_rest = static.at(Signal(TIME, TIME))
    signals = run(tension=1.2 * at_rest, uncompensated_tension=np.where(TIME < 100.0, 1.5, 0.5) * at_rest)
    signals.static_tension = static
    values = kpi_set.evaluate(signals)
    assert values["dynamic_amplification"] == pytest.approx(1.2)
    assert values["tension_ratio_min"] == pytest.approx(1.2)
    assert values["uncompensated_dynamic_amplification"] == pytest.approx(1.5)
    assert values["uncompensated_tension_ratio_min"] == pytest.approx(0.5)
    assert values["snaps"] == values["uncompensated_snaps"] == 0.0


def test_time_at_limit_counts_speed_or_acceleration_but_not_twice():
    signals = run(payout_rate=np.where(TIME < 50, 2.0, 0.1), payout_acceleration=np.where(TIME < 100, 1.5, 0.0))
    signals.speed_limit, signals.acceleration_limit = 2.0, 1.5
    values = kpi_set.evaluate(signals)
    assert values["time_at_speed_limit_percent"] == pytest.approx(25.0)
    assert values["time_at_limit_percent"] == pytest.approx(50.0)


LIMIT_KEYS = {
    WinchLimit.SPEED: "time_at_speed_limit_percent",
    WinchLimit.ACCELERATION: "time_at_acceleration_limit_percent",
    WinchLimit.PAYOUT: "time_at_payout_limit_percent",
    WinchLimit.POWER: "time_at_power_limit_percent",
    WinchLimit.TORQUE: "time_at_torque_limit_percent",
    WinchLimit.PRESSURE: "time_at_pressure_limit_percent",
    WinchLimit.FLOW: "time_at_flow_limit_percent",
}


def test_every_limit_that_a_winch_can_tell_has_a_share_of_time():
    assert set(LIMIT_KEYS) == set(WinchLimit) - {WinchLimit.NONE}
    assert set(LIMIT_KEYS.values()) <= set(kpi_set.DEFINITION_OF)


@given(st.lists(st.integers(0, 127), min_size=4, max_size=4))
def test_shares_of_time_at_limits_are_what_the_winch_tells_and_agree_with_that_of_any(flags):
    told = np.repeat(flags, TIME.size // 4)
    moving = np.full(told.size, 0.1)
    signals = run(payout_rate=moving, payout_acceleration=moving, limits_hit=told.astype(float))
    signals.speed_limit = signals.acceleration_limit = 2.0
    values = kpi_set.evaluate(signals)
    for limit, key in LIMIT_KEYS.items():
        assert values[key] == 25.0 * sum(bool(flag & limit) for flag in flags)
    shares = [values[key] for key in LIMIT_KEYS.values()]
    assert max(shares) <= values["time_at_limit_percent"] <= sum(shares)
    assert values["time_at_limit_percent"] == 25.0 * sum(flag != 0 for flag in flags)


def test_a_speed_close_to_its_limit_is_not_at_it_where_the_winch_tells_when_it_is():
    told = np.where(TIME < 50.0, WinchLimit.ACCELERATION, WinchLimit.NONE)
    signals = run(payout_rate=np.full(TIME.size, 2.0), limits_hit=told.astype(float))
    signals.speed_limit = 2.0
    values = kpi_set.evaluate(signals)
    assert values["time_at_speed_limit_percent"] == 0.0
    assert values["time_at_acceleration_limit_percent"] == values["time_at_limit_percent"] == pytest.approx(25.0)


def test_people_see_the_limits_of_power_torque_pressure_flow_and_payout_only_where_they_acted():
    seen = {
        flag: {one.key for one in shown([kpi_set.evaluate(run(payout_rate=TIME, limits_hit=0 * TIME + flag))])}
        for flag in (0, WinchLimit.POWER)
    }
    assert "time_at_power_limit_percent" not in seen[0]
    assert "time_at_power_limit_percent" in seen[WinchLimit.POWER]
    assert not {"time_at_torque_limit_percent", "time_at_payout_limit_percent"} & seen[WinchLimit.POWER]
    assert {"time_at_speed_limit_percent", "time_at_limit_percent"} <= seen[0]


HEIGHT = np.interp(TIME, [0.0, 100.0, 130.0], [-560.0, -560.0, -590.0])
"""Height of a unit that is lowered at 1 m/s from 100 s on [m]."""


def landed(touching: np.ndarray, held: np.ndarray, height: np.ndarray = HEIGHT) -> dict[str, float]:
    return kpi_set.evaluate(run(unit_height=height, touchdown=touching, holds_tension=held))


def test_a_landing_has_the_speed_of_lowering_and_the_time_until_tension_is_held():
    values = landed(TIME >= 120.0, TIME >= 121.5)
    assert (values["landings"], values["landings_held"], values["lift_offs"]) == (1.0, 1.0, 0.0)
    assert values["touchdown_speed_mps"] == pytest.approx(1.0)
    assert values["landing_to_tension_s"] == pytest.approx(1.5)


def test_a_unit_that_bounces_has_landed_once_with_its_rebound():
    height = np.where((TIME > 121.0) & (TIME < 122.0), -579.7, np.where(TIME >= 120.0, -580.0, HEIGHT))
    values = landed((TIME >= 120.0) & ~((TIME > 121.0) & (TIME < 122.0)), TIME < 0.0, height)
    assert (values["landings"], values["landings_held"], values["lift_offs"]) == (1.0, 0.0, 1.0)
    assert values["touchdown_rebound_m"] == pytest.approx(0.3)
    assert math.isnan(values["landing_to_tension_s"])


def test_what_lies_on_the_bottom_from_the_start_has_not_landed_and_two_places_are_two_landings():
    assert landed(TIME < 50.0, TIME < 0.0)["landings"] == 0.0
    twice = ((TIME > 110.0) & (TIME < 120.0)) | (TIME > 140.0)
    assert landed(twice, TIME > 145.0)["landings_held"] == 1.0
    assert landed(twice, TIME > 145.0)["landings"] == 2.0


def test_an_efficiency_counts_only_while_the_unit_hangs():
    """Landed from 100 s on, five whole periods in, where it lies still and the locked winch's unit goes on."""
    lying = TIME >= 100.0
    heave = np.where(lying, 0.0, sine(0.1))
    values = kpi_set.evaluate(run(unit_heave=heave, uncompensated_heave=sine(1.0), touchdown=lying))
    assert values["unit_efficiency"] == pytest.approx(0.9)


def test_a_change_of_mode_is_charged_with_what_follows_within_ten_seconds():
    changes = np.isclose(TIME, 50.0)
    heave = 0.01 * np.isclose(TIME, 58.0) + 0.5 * np.isclose(TIME, 61.0)
    values = kpi_set.evaluate(run(mode_changes=changes, losses=changes, unit_heave=heave))
    assert (values["mode_changes"], values["compensation_losses"]) == (1.0, 1.0)
    assert values["mode_change_heave_max_m"] == pytest.approx(0.01, rel=0.05)


def test_people_see_what_counts_events_only_where_there_were_any():
    without, with_one = (landed(touching, TIME < 0.0) for touching in (TIME < 0.0, TIME >= 120.0))
    assert without["landings"] == 0.0
    assert kpi_set.LANDING not in {one.group for one in shown([without])}
    assert kpi_set.LANDING in {one.group for one in shown([without, with_one])}


@pytest.mark.parametrize(("period", "samples"), [(0.05, 6000), (0.1, 2500), (0.07, 3000), (1.0, 70), (2.0, 100)])
def test_ratios_over_windows_are_those_of_the_samples_of_each(period, samples):
    """numpy.std of each window is the reference, also where a calm follows on a storm and a unit is moved by 100 m."""
    random = np.random.default_rng(5)
    time = period * np.arange(samples)
    unit = np.where(time < 0.5 * time[-1], 1e2, 1e-2) * random.standard_normal(samples)
    off = random.standard_normal(samples) + np.where(time < 0.3 * time[-1], 0.0, 100.0)
    starts, ratios = kpi.window_ratios(time, unit, off, 3.0, floor=0.02)
    count, step = round(kpi.WORSE_WINDOW / period), max(1, round(1.0 / period))
    firsts = np.arange(np.searchsorted(time, 3.0), samples - count + 1, step)
    windows = [(unit[first : first + count].std(), off[first : first + count].std()) for first in firsts]
    np.testing.assert_array_equal(starts, time[firsts])
    np.testing.assert_allclose(ratios, [one / max(other, 0.02) for one, other in windows], rtol=1e-12)
    assert len(kpi.window_ratios(time[: count - 1], unit[: count - 1], off[: count - 1], 0.0)[0]) == 0


def test_what_moving_costs_a_rope_needs_its_turns_alone():
    """Play taken of every sample is the reference."""
    random = np.random.default_rng(6)
    time = 0.05 * np.arange(4000)
    payout = 0.03 * np.cumsum(random.standard_normal(4000)) * np.sin(0.05 * time)
    swings = kpi._after_play(payout, kpi.BENDING_STROKE)
    wear = kpi.rope_wear(time, payout)
    rises = np.sign(np.diff(swings))
    turns = np.count_nonzero(np.diff(rises[rises != 0.0]))
    assert wear.reversals * time[-1] / 3600.0 == pytest.approx(turns, rel=1e-12)
    assert wear.bending_cycles * time[-1] / 3600.0 == pytest.approx(kpi._most_crossed(swings), rel=1e-12)
