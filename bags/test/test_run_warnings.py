"""What a reader of a run is warned of: harm, compensation that was not active, and what others would have done."""

import math
from dataclasses import replace

import numpy as np
import pytest
from heave_bags.analyse import analysis, run_warnings, run_words
from heave_bags.analyse.events import Interval
from heave_bags.analyse.read_run import read_run
from heave_bags.report import headline, report
from heave_bags.signals import Signal
from heave_node.criteria import Criterion
from made_up_run import MadeUpRun
from numpy import arange, sin, where

TOLD = "the encoder goes the other way than the winch is sent; in {} s at best"


@pytest.fixture
def record(shared_bag):
    """Return a run of 300 s whose unit moves a third of what it would uncompensated, all along in mode compensating."""
    (record,) = analysis.analyse([shared_bag])
    record.start, record.end = 10.0, 300.0
    time = arange(0.0, 300.0, 0.05)
    record.signals.uncompensated_heave = Signal(time, sin(time))
    record.signals.unit_heave = Signal(time, sin(time) / 3.0)
    record.signals.compensating = Signal(time, 1.0 + 0.0 * time)
    record.modes = [Interval(0.0, 20.0, "standby"), Interval(20.0, 300.0, "compensating")]
    record.waits = [Interval(0.0, 20.0, "standby", reason="estimate settling, 0 s more")]
    record.alarms = []
    return record


def warned(record):
    values = {"unit_efficiency": 0.5, "outlet_efficiency": 0.5, "baseline_efficiency": math.nan}
    return run_warnings.warnings(record, {**record.kpis(), **values})


def test_a_run_that_does_no_harm_and_compensates_is_not_warned_of(record):
    assert warned(record) == []


@pytest.mark.parametrize(("times", "is_reported"), [(3.0, False), (3.3, True), (6.0, True)])
def test_a_unit_that_moves_more_than_uncompensated_is_told_with_times_and_ratio(record, times, is_reported):
    """Of 100 s in which the unit moves `times` a third of off, some windows of 60 s see nothing else."""
    time, unit = record.signals.unit_heave.time, record.signals.unit_heave.value
    record.signals.unit_heave = Signal(time, where((time >= 100.0) & (time < 200.0), times, 1.0) * unit)
    found = run_warnings.worse_times(record)
    assert bool(found) is is_reported
    if is_reported:
        (one,) = found
        assert one.ratio == pytest.approx(times / 3.0, rel=0.01)
        # a part of a window of 60 s must lie in the 100 s before it can be worse
        assert 85.0 < one.start < 130.0 <= one.at <= 170.0 < one.end < 215.0
        (text,) = warned(record)
        when = f"from {one.start:.0f} s to {one.end:.0f} s, worst {one.ratio:.2f}x at {one.at:.0f} s, in compensating"
        assert text == f"Load moved more than with the winch locked (rolling 60 s) {when}"
        assert text in report.render([record])
        (told,) = [one for one in run_words.happenings(record) if one.text.startswith("load moved more")]
        assert (told.start, told.end, told.level) == (one.start, one.end, 2)
        assert told.text.endswith(f"worst {one.ratio:.2f}x at {one.at:.0f} s, in compensating")


def test_a_unit_that_hardly_moves_is_not_worse_than_one_that_does_not_move_at_all(record):
    """In calm water noise moves a unit that is held by millimetres: not 1.05 times 2 cm of standard deviation."""
    off = record.signals.uncompensated_heave
    record.signals.uncompensated_heave = Signal(off.time, 0.001 * off.value)
    for sigma, is_reported in ((0.0209, False), (0.0211, True)):
        record.signals.unit_heave = Signal(off.time, math.sqrt(2.0) * sigma * off.value)
        assert bool(run_warnings.worse_times(record)) is is_reported


def test_what_the_unit_does_before_compensation_first_begins_is_not_held_against_it(record):
    time, unit = record.signals.unit_heave.time, record.signals.unit_heave.value
    record.signals.unit_heave = Signal(time, where(time < 20.0, 30.0, 1.0) * unit)
    assert run_warnings.worse_times(record) == []


def test_why_compensation_never_began_is_told_in_the_words_of_the_controller(record):
    record.modes = [Interval(0.0, 300.0, "standby")]
    record.signals.compensating = Signal(record.signals.unit_heave.time, 0.0 * record.signals.unit_heave.time)
    record.waits = [
        Interval(0.0, 20.0, "standby", reason="estimate settling, 0 s more"),
        Interval(20.0, 120.0, "standby", reason="mru nan"),
        Interval(120.0, 220.0, "standby", reason=TOLD.format(5)),
        Interval(220.0, 300.0, "standby", reason=TOLD.format(4)),
    ]
    frozen = "winch_controller: sensor mru: SENSOR_LOST, MRU (high): readings do not change. {}. Restart the sensor."
    words = ("Compensation continues", "Compensation is fading out")
    record.alarms = [Interval(20.0, 21.0, frozen.format(loop), level=2) for loop in words]
    record.alarms += [Interval(21.0, 22.0, "winch_controller: sensor mru: nan: start it again", level=2)]
    record.alarms += [Interval(21.0, 22.0, "winch_controller: alarms: only a warning", level=1)]
    (text,) = warned(record)
    assert text == (
        f"Compensation never began. Reasons: standby for 180 s ({TOLD.format(4)}); standby for 100 s (mru nan). "
        "Alarms: SENSOR_LOST, MRU; winch_controller: sensor mru: nan: start it again"
    )


def test_why_compensation_was_seldom_in_force_is_told_and_a_rest_that_was_asked_for_is_none(record):
    time = record.signals.unit_heave.time
    record.modes += [Interval(60.0, 300.0, "standby")]
    record.signals.compensating = Signal(time, where(time < 60.0, 1.0, 0.0))
    record.waits += [Interval(60.0, 300.0, "standby", reason="mru nan")]
    (text,) = warned(record)
    assert text.startswith(
        "Compensation was active for 17.2 % of the time from 10 s to 300 s. Reasons: standby for 240 s (mru nan)"
    )
    record.modes[-1] = record.waits[-1] = Interval(60.0, 300.0, "standby", reason="standby requested")
    assert warned(record) == []


def test_a_run_that_an_operator_stopped_early_is_not_told_why_it_was_not_in_force(record):
    """Of the 40 s before the stop it was in standby for 30 s; nothing says that it would not have gone on."""
    record.start, record.end = 0.0, 45.0
    record.is_past_transient = False
    time = record.signals.unit_heave.time
    record.signals.compensating = Signal(time, where((time >= 30.0) & (time < 40.0), 1.0, 0.0))
    record.modes = [Interval(0.0, 30.0, "standby"), Interval(30.0, 40.0, "compensating")]
    record.waits = [Interval(0.0, 30.0, "standby", reason="depth nan")]
    record.modes.append(Interval(40.0, 45.0, "standby", reason="depth nan"))
    (text,) = warned(record)
    assert text.startswith("Compensation was active for")
    record.modes[-1] = Interval(40.0, 45.0, "standby", reason="standby requested")
    assert warned(record) == []


@pytest.mark.parametrize(
    ("unit", "outlet", "baseline", "words"),
    [
        (0.9, 0.9, 0.8, []),
        (0.9, 0.9, math.nan, []),
        (0.8, 0.9, 0.9, ["The load moved more than under an industrial controller in the same sea (efficiency 80.0 %"]),
        (-0.1, 0.2, math.nan, ["The load moved more than with the winch locked (efficiency -10.0 %)"]),
        (0.1, -0.2, math.nan, ["The rope at the boom tip moved more than with the winch locked (efficiency -20.0 %)"]),
        (-0.001, -0.001, 0.001, []),
        (
            -0.0001,
            0.0,
            0.9,
            ["The load moved more than under an industrial controller in the same sea (efficiency 0.0 %"],
        ),
    ],
)
def test_a_winch_that_does_harm_or_less_than_another_would_is_told_in_words(shared_bag, unit, outlet, baseline, words):
    (record,) = analysis.analyse([shared_bag])
    values = record.kpis() | {"unit_efficiency": unit, "outlet_efficiency": outlet, "baseline_efficiency": baseline}
    found = run_warnings.warnings(record, values)
    assert [text.startswith(word) for text, word in zip(found, words, strict=True)] == [True] * len(words)


def test_a_run_of_no_length_has_nothing_to_be_warned_of(made_up_bag):
    """One sample: the evaluation window is empty, and no share of it means anything."""
    record = read_run(made_up_bag(run=MadeUpRun(duration=0.05)))
    assert record.end == record.start
    assert [line for line in run_warnings.warnings(record, record.kpis()) if "active for" in line] == []


def test_a_time_without_harm_between_two_with_harm_belongs_to_neither(record):
    """The load moves twice as much as with the winch locked from 60 s to 100 s and from 200 s to 240 s."""
    time = record.signals.unit_heave.time
    harmed = ((time >= 60.0) & (time < 100.0)) | ((time >= 200.0) & (time < 240.0))
    record.signals.unit_heave = Signal(time, where(harmed, 6.0, 1.0) * record.signals.unit_heave.value)
    one, other = run_warnings.worse_times(record)
    assert one.end < 130.0, "a window of 60 s about it no longer sees the first"
    assert other.start > 170.0


@pytest.mark.parametrize(
    ("at_tip", "at_load", "is_said"),
    [(0.98, 0.52, True), (0.985, 0.96, False), (0.42, 0.38, False), (0.5, math.nan, False)],
)
def test_why_the_load_swings_under_the_industrial_controller_is_said_with_its_natural_period(
    record, at_tip, at_load, is_said
):
    """Thesis 6.2.6: 15.77 MN over 900 m, 125 t and a third of the rope's 6.5 t: 16.9 s."""
    record.parameters["cable_sim"] = {
        "length": 900.0,
        "unit.mass": 65000.0,
        "unit.added_mass": [60000.0, 60000.0, 60000.0],
        "cable.mass_per_length": 7.2,
        "cable.axial_stiffness": 15770645.9,
    }
    values = {**record.kpis(), "baseline_outlet_efficiency": at_tip, "baseline_efficiency": at_load}
    said = headline.on_industrial(record, values)
    assert ("natural period (17 s)" in said) is is_said


def test_a_criterion_that_a_run_is_not_judged_by_bounds_no_figure(record):
    record.wanted = [Criterion("unit_sigma_m", "<=", 1e-6)]
    assert headline.note(record, "unit_sigma_m") == "required at most 0.0001 cm"
    assert headline.is_missed(record, "unit_sigma_m", 0.01)
    record.end = record.start + 30.0
    assert headline.note(record, "unit_sigma_m") == ""
    assert not headline.is_missed(record, "unit_sigma_m", 0.01)


@pytest.mark.parametrize("active, is_said", [(0.186, True), (1.0, False)])
def test_a_baseline_that_lost_compensation_is_not_compared_without_a_word(record, active, is_said):
    record.parameters["cable_sim"] = {}
    time = np.linspace(record.start, record.end, 1001)
    share = np.linspace(0.0, 1.0, 1001)
    record.signals.baseline = replace(
        record.signals, compensating=Signal(time, (share <= active).astype(float)), lost="at 220 s: x"
    )
    values = {**record.kpis(), "baseline_outlet_efficiency": 0.2, "baseline_efficiency": 0.19}
    assert (
        "compensation active 19 % of the time, lost at 220 s: x." in headline.on_industrial(record, values)
    ) is is_said
    assert ("active 19 % of the time" in headline.note(record, "baseline_efficiency")) is is_said
