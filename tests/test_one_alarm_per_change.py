"""A winch that changes in the middle of a run: the change is reported once."""

import re
from dataclasses import replace

import pytest
from cable_sim_node.winch.component import make_drive
from heave_bringup.closed_loop import ClosedLoop
from heave_node.interface.alarm import alarms_in
from heave_studies.promise.run import blamed_by

from tests.loops import fault, loop_of, quick_parameters

CHANGED, DURATION = 120.0, 300.0
"""When the winch changes, and end of the run [s]."""

GAIN_TOLD = (
    re.compile(r"WINCH_MODEL_UPDATED \(event\): gain by the encoder ([\d.]+) \(was [\d.]+\)\..*"),
    re.compile(r"IDENTIFIED, ENCODER \(event\): reads ([\d.]+) times.*"),
)
"""Orders and readings do not distinguish a gain of the winch from one of its encoder."""

DELAY_TOLD = (re.compile(r"WINCH_MODEL_UPDATED \(event\): command delay ([\d.]+) s \(was [\d.]+\)\..*"),)


def alarms_of(**changes):
    """Return time and words of what is reported of parts of benchmark B3, whose winch has `changes` from CHANGED on.

    Reports that a part of the sea is not compensated meanwhile, and that commands take effect later, count as well.
    """
    loop = loop_of("b3_deep_900", {"wave_vessel.ramp": 20}, duration=DURATION)
    winch = loop.winch

    def change(tick, _):
        if tick == round(CHANGED / 0.05):
            winch._parameters = replace(winch._parameters, **changes)
            drive = make_drive(winch._parameters, 0.0)
            drive.state = winch._drive.state
            winch._drive = drive
            winch._line._delay = winch._parameters.command_delay

    return loop.run(change).alarms


def parts_told(alarms):
    """Return the `alarms` that say what is assumed of a part."""
    return [(time, str(alarm)) for time, alarm in alarms if names_a_part(alarm)]


def names_a_part(alarm):
    """Tell whether an `alarm` says what a part is like."""
    (read,) = alarms_in(str(alarm))
    return (
        alarm.code.endswith("_MODEL_UPDATED") or alarm.code.startswith("NOMINAL") or bool(blamed_by(read, noise=False))
    )


def assert_told_once(told, forms, value):
    """Check that of the reports `told` about parts there is one, in one of the `forms`, with its `value`."""
    assert len(told) == 1, told
    time, words = told[0]
    assert CHANGED < time < CHANGED + 60.0
    found = next(filter(None, (form.fullmatch(words) for form in forms)), None)
    assert found is not None, words
    assert float(found.group(1)) == pytest.approx(value, rel=0.07)


@pytest.mark.slow
@pytest.mark.parametrize("gain", [0.85, 1.15], ids=["lower gain", "higher gain"])
def test_a_change_of_the_gain_is_told_of_the_encoder_or_the_winch(gain):
    """All at once it is the encoder's, for no drum changes so; the depth sensor may tell later it is the drum's."""
    alarms = alarms_of(speed_gain=gain)
    first, *later = parts_told(alarms)
    assert_told_once([first], GAIN_TOLD, gain)
    values = [form.fullmatch(words) for _, words in later for form in GAIN_TOLD]
    assert all(float(found.group(1)) == pytest.approx(gain, rel=0.07) for found in values if found is not None)
    assert all(
        words.startswith(("IDENTIFIED, ENCODER", "NOMINAL, ENCODER", "WINCH_MODEL_UPDATED (event): gain by"))
        for _, words in later
    )
    assert not any(alarm.name.startswith("COMMANDS_") for _, alarm in alarms)


@pytest.mark.slow
def test_a_change_of_the_delay_is_one_alarm_that_names_it():
    alarms = alarms_of(command_delay=0.3)
    assert_told_once(parts_told(alarms), DELAY_TOLD, 0.3)
    assert "COMMANDS_LATE: delay" in {alarm.name for _, alarm in alarms}


@pytest.mark.slow
def test_a_winch_that_stays_as_it_is_gives_none():
    alarms = alarms_of()
    assert not parts_told(alarms)
    assert "winch" not in {alarm.row.part for _, alarm in alarms}


@pytest.mark.parametrize(("kind", "size", "reason"), [("scale", -1.0, "jump"), ("nan", 0.0, "nan")])
def test_a_sensor_that_is_lost_has_one_name_from_the_first_alarm_on(kind, size, reason):
    """The first readings that are refused, the loss and the mode said three things of one event within 1.6 s."""
    record = ClosedLoop(quick_parameters(fault("mru", kind, 25.0, size=size), duration=30.0)).run()
    names = [(alarm.name, alarm.values.get("reason")) for time, alarm in record.alarms if time > 24.0]
    assert [name for name, _ in names] == [f"SENSOR_LOST, MRU: {reason}", "COMPENSATION_LOST"]
    assert str(names[-1][1]).startswith(f"mru {reason};")


def test_one_reading_that_is_refused_is_told_once_the_next_is_not():
    loop = ClosedLoop(quick_parameters(fault("mru", "nan", 25.0, lasting=0.04), duration=27.0))
    told = [(time, alarm.name) for time, alarm in loop.run().alarms if time > 24.0]
    assert told == [(pytest.approx(25.1, abs=0.06), "SENSOR_DOUBTFUL, MRU: one reading")]
