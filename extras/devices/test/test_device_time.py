"""The own time of a device only goes on."""

from heave_devices.formats.device_time import COUNTER_WRAP, DeviceTime
from heave_devices.formats.sample import Sample, TimeBase


def at(time, base, kind="X"):
    return Sample(kind, {}, time=time, time_base=base)


def test_the_time_of_the_day_goes_on_past_midnight():
    clock = DeviceTime()
    before, after = (clock.nanoseconds(at(time, TimeBase.DAY)) for time in (86_399.5, 0.5))
    assert after - before == 1_000_000_000


def test_a_sample_that_is_late_across_midnight_is_put_before_it():
    clock = DeviceTime()
    _, after, late = (clock.nanoseconds(at(time, TimeBase.DAY)) for time in (86_399.8, 0.1, 86_399.9))
    assert after - late == 200_000_000


def test_a_counter_of_milliseconds_goes_on_where_its_32_bits_end():
    clock = DeviceTime()
    before, after = (clock.nanoseconds(at(time, TimeBase.COUNTER)) for time in (COUNTER_WRAP - 0.1, 0.1))
    assert abs(after - before - 200_000_000) < 1000


def test_the_date_of_zda_makes_the_time_of_the_day_utc():
    clock = DeviceTime()
    clock.nanoseconds(at(837_192_489.456, TimeBase.UNIX, "ZDA"))
    assert clock.nanoseconds(at(17 * 3600 + 28 * 60 + 10.0, TimeBase.DAY)) == 837_192_490_000_000_000


def test_a_sample_without_a_time_has_none():
    assert DeviceTime().nanoseconds(Sample("X", {})) is None
