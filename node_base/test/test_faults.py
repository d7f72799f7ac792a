"""Faults of any device: one vocabulary, what is active when, and clear."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest
from heave_node.interface.fault_kinds import FAULTS, LARGEST_DELAY, faults_of
from heave_node.interface.faults import FaultParameters, FaultSchedule, FaultyValues
from hypothesis import given
from hypothesis import strategies as st

README = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")
DEVICES = ("sensor", "mru", "encoder", "winch")


def schedule(*faults: tuple[str, float, float, float], device: str = "sensor", **usual: float) -> FaultSchedule:
    columns = tuple(zip(*faults, strict=True)) or ((), (), (), ())
    return FaultSchedule(FaultParameters(*columns), name="probe", device=device, usual_duration=usual)


def test_a_fault_is_active_from_its_start_until_its_end():
    faults = schedule(("gap", 1.0, 0.5, 0.0))
    assert [faults.is_active("gap", time) for time in (0.99, 1.0, 1.49, 1.5)] == [False, True, True, False]


def test_a_fault_without_a_duration_lasts_to_the_end_of_the_run():
    assert schedule(("gap", 1.0, 0.0, 0.0)).is_active("gap", 1e9)


def test_a_kind_may_have_a_usual_duration():
    faults = schedule(("restart", 1.0, 0.0, 0.0), device="mru", restart=2.0)
    assert [faults.is_active("restart", time) for time in (1.0, 2.99, 3.0)] == [True, True, False]


def test_magnitudes_of_faults_that_are_active_together_add_up_and_the_newest_rate_counts():
    faults = schedule(
        ("jump", 0.0, 0.0, 1.0), ("jump", 1.0, 0.0, 0.5), ("rate", 0.0, 0.0, 5.0), ("rate", 1.0, 1.0, 2.0)
    )
    assert [faults.total("jump", time) for time in (0.5, 1.5)] == [1.0, 1.5]
    assert [faults.newest("rate", time) for time in (0.5, 1.5, 2.5)] == [5.0, 2.0, 5.0]


def test_jitter_is_uniform_up_to_its_magnitude_beside_a_delay_and_that_of_its_seed():
    columns = FaultParameters(("jitter", "delay"), (1.0, 0.0), (1.0, 0.0), (0.2, 0.5))
    runs = [
        np.array([schedule.lateness(1.0) - 0.5 for _ in range(2000)])
        for seed in (1, 1, 2)
        for schedule in [FaultSchedule(columns, name="probe", device="sensor", seed=seed)]
    ]
    np.testing.assert_array_equal(runs[0], runs[1])
    assert not np.array_equal(runs[0], runs[2])
    assert runs[0].min() >= 0.0
    assert runs[0].max() <= 0.2
    # mean and deviation of a uniform distribution, within four of their own deviations for 2,000 draws
    assert (runs[0].mean(), runs[0].std()) == pytest.approx((0.1, 0.2 / math.sqrt(12.0)), abs=0.0052)
    assert FaultSchedule(columns, name="probe", device="sensor").lateness(2.5) == 0.5


@pytest.mark.parametrize("device", DEVICES)
def test_clear_ends_every_fault_that_is_active_and_leaves_later_ones(device):
    kind = faults_of(device)[0]
    faults = schedule((kind, 1.0, 0.0, 0.0), (kind, 5.0, 0.0, 0.0), device=device)
    faults.inject("clear", start=2.0)
    assert [faults.is_active(kind, time) for time in (1.9, 2.0, 4.9, 5.0)] == [True, False, False, True]


def test_clear_can_be_scheduled_like_any_other_kind_wherever_it_stands_in_the_list():
    faults = schedule(("clear", 2.0, 0.0, 0.0), ("gap", 1.0, 0.0, 0.0))
    assert [faults.is_active("gap", time) for time in (1.9, 2.0)] == [True, False]


def test_a_fault_that_was_cleared_before_it_happened_does_not_happen():
    faults = schedule(("spike", 1.0, 0.0, 3.0), ("restart", 1.0, 0.0, 0.0), device="mru")
    faults.inject("clear", start=1.0)
    assert faults.take_once("spike", 1.0) == 0.0
    assert faults.take_begun("restart", 1.0) is None


def test_what_happens_once_is_taken_once():
    faults = schedule(("spike", 1.0, 0.0, 3.0), ("restart", 1.02, 0.01, 0.0), device="mru")
    assert [faults.take_once("spike", time) for time in (0.95, 1.0, 1.05)] == [0.0, 3.0, 0.0]
    # a restart between two ticks is a restart
    assert faults.take_begun("restart", 1.0) is None
    assert faults.take_begun("restart", 1.05) is not None
    assert faults.take_begun("restart", 1.1) is None


@pytest.mark.parametrize(
    ("device", "fault", "message"),
    [
        ("sensor", ("drive", 0.0, 0.0, 0.0), "probe: a fault of kind drive is unknown; known: freeze, gap"),
        ("mru", ("bias", 0.0, 0.0, 0.0), "a fault of kind bias is unknown; known: freeze, gap, spike, jump"),
        ("sensor", ("gap", 0.0, -1.0, 0.0), "a fault needs a finite start, a duration of at least 0 s"),
        ("sensor", ("jump", 0.0, 1.0, math.nan), "and a finite magnitude; got 0.0, 1.0, nan"),
        ("sensor", ("rate", 0.0, 1.0, 0.0), "the magnitude of kind rate must be above 0 Hz; got 0"),
        ("mru", ("scale", 0.0, 1.0, 0.0), "the magnitude of kind scale must be a factor that is not 0"),
        ("sensor", ("delay", 0.0, 1.0, -0.1), "the magnitude of kind delay must be from 0 to inf s; got -0.1"),
        ("mru", ("delay", 0.0, 1.0, 11.0), "the magnitude of kind delay must be from 0 to 10 s; got 11"),
        ("winch", ("jitter", 0.0, 1.0, -0.1), "the magnitude of kind jitter must be from 0 to inf s; got -0.1"),
    ],
)
def test_a_fault_that_cannot_be_is_refused_in_one_line(device, fault, message):
    for refused in (
        lambda: schedule(fault, device=device),
        lambda: schedule(device=device).inject(fault[0], start=fault[1], duration=fault[2], magnitude=fault[3]),
    ):
        with pytest.raises(ValueError, match=re.escape(message)) as error:
            refused()
        assert "\n" not in str(error.value)


def test_lists_of_unequal_length_are_refused_by_the_name_of_the_device():
    with pytest.raises(ValueError, match=r"mru.faults: the lists .* must have the same length; got 1, 2, 0, 0"):
        FaultParameters(("gap",), (1.0, 2.0)).check("mru.faults", "mru")


def test_values_freeze_at_the_last_sample_spike_once_jump_and_are_no_numbers():
    faults = schedule(
        ("freeze", 2.0, 2.0, 0.0), ("spike", 5.0, 0.0, 9.0), ("jump", 7.0, 2.0, -1.0), ("nan", 8.0, 1.0, 0.0)
    )
    values = FaultyValues(faults)
    said = [float(values.apply(float(time), np.array([float(time)]))[0]) for time in range(11)]
    assert said == pytest.approx([0, 1, 1, 1, 4, 14, 6, 6, math.nan, 9, 10], nan_ok=True)


def test_values_are_multiplied_by_all_scales_that_are_active_and_then_offset():
    values = FaultyValues(schedule(("scale", 1.0, 2.0, -1.0), ("scale", 2.0, 2.0, 0.5), ("jump", 3.0, 2.0, 1.0)))
    said = [float(values.apply(time, np.array([8.0]))[0]) for time in (0.0, 1.0, 2.0, 3.0, 4.0, 5.0)]
    assert said == [8.0, -8.0, -4.0, 5.0, 9.0, 8.0]


def test_a_scale_may_be_of_some_axes_alone():
    values = FaultyValues(schedule(("scale", 0.0, 0.0, -1.0)), scaled=np.array([1.0, 0.0]))
    assert values.apply(1.0, np.array([5.0, 6.0])).tolist() == [-5.0, 6.0]


def test_a_device_that_is_frozen_from_its_first_sample_repeats_that():
    values = FaultyValues(schedule(("freeze", 0.0, 2.0, 0.0)))
    assert [float(values.apply(float(time), np.array([float(time)]))[0]) for time in (1, 2)] == [1.0, 2.0]
    values = FaultyValues(schedule(("freeze", 0.0, 5.0, 0.0)))
    assert [float(values.apply(float(time), np.array([float(time)]))[0]) for time in (1, 2)] == [1.0, 1.0]


def test_an_error_may_be_of_some_axes_alone():
    values = FaultyValues(schedule(("jump", 0.0, 0.0, 2.0)), axes=np.array([1.0, 0.0]))
    assert values.apply(1.0, np.array([5.0, 6.0])).tolist() == [7.0, 6.0]


@given(
    st.lists(
        st.tuples(st.sampled_from(faults_of("mru")), st.floats(0.0, 9.0), st.floats(0.0, 5.0), st.floats(0.1, 9.0)),
        max_size=6,
    )
)
def test_after_a_clear_nothing_that_began_before_is_active(drawn):
    faults = schedule(*drawn, device="mru")
    faults.inject("clear", start=10.0)
    assert not faults.any_active(10.0)


@pytest.mark.parametrize("kind", FAULTS)
def test_the_readme_has_the_vocabulary(kind):
    fault = FAULTS[kind]
    known = " | ".join("x" if device in fault.devices else "" for device in DEVICES)
    row = f"| `{kind}` | {fault.words} | {fault.magnitude or '-'} | {known} |"
    assert re.sub(r" +", " ", row) in re.sub(r" +", " ", README), f"wanted: {row}"


def test_what_a_fault_does_to_a_device_says_nothing_of_others():
    assert FAULTS["gap"].of("mru") == "no samples"
    assert FAULTS["gap"].of("winch") == "commands are lost"
    assert not any(other in FAULTS[kind].of("sensor") for kind in FAULTS for other in ("mru", "winch"))


def test_every_delay_that_is_bounded_says_so():
    assert f"at most {LARGEST_DELAY['mru']:g}" in FAULTS["delay"].magnitude
