"""What a real winch does wrong, one fault after the other: what the rope does of it, and when the drive's supervision
stops the drum. Expected speeds are those ordered; times are the supervision's, a tick and the servo's lag.
"""

import pytest
from cable_sim_node.alarms import fault_alarm
from cable_sim_node.winch.component import VirtualWinch, WinchCommand
from cable_sim_node.winch.drives.interface import DriveCommand, DriveState
from cable_sim_node.winch.faulty_drum import FaultyDrum
from cable_sim_node.winch.parameters import WinchParameters
from heave_node.interface.codes import WinchFault, WinchLimit, WinchRelease
from heave_node.interface.faults import FaultParameters, FaultSchedule
from hypothesis import given
from hypothesis import strategies as st

TICK, TENSION, LAG = 0.05, 30e3, 0.15
SUPERVISED = 1.0


class Bench:
    def __init__(self, **parameters):
        self.winch = VirtualWinch(WinchParameters(command_delay=0.0, **parameters), tick_period=TICK)
        self.number = 0

    @property
    def state(self):
        return self.winch.state

    def run(self, seconds, rate=0.0, brake=False, tension=TENSION):
        """Command for a time [s]; return the time until a fault is latched, or the whole time [s]."""
        for ticks in range(round(seconds / TICK)):
            self.number += 1
            self.winch.step(self.winch.tick, WinchCommand(self.number, 0.0, rate, brake), tension)
            if self.state.fault:
                return (ticks + 1) * TICK
        return seconds

    def inject(self, kind, magnitude=0.0, duration=0.0):
        now = self.winch.tick * TICK
        self.winch.faults.inject(kind, start=now, duration=duration, magnitude=magnitude)


def test_a_drum_that_turns_against_the_command_lets_out_what_is_to_be_hauled_in():
    """Without the supervision, which every drive has unless it is taken away."""
    bench = Bench(supervision_time=0.0)
    bench.inject("reverse")
    bench.run(2.0, rate=-0.3)
    assert bench.state.payout_rate == pytest.approx(0.3, rel=1e-3)


@pytest.mark.parametrize("rate", [0.0, 0.4])
def test_a_drum_that_creeps_pays_out_besides_what_it_is_ordered_and_a_slack_cable_does_not(rate):
    bench, sound = Bench(), Bench()
    bench.inject("creep", 0.05)
    for one in (bench, sound):
        one.run(3.0, rate=rate)
    assert bench.state.payout - sound.state.payout == pytest.approx(0.05 * 3.0)
    bench.run(2.0, rate=rate, tension=0.0)
    sound.run(2.0, rate=rate, tension=0.0)
    assert bench.state.payout - sound.state.payout == pytest.approx(0.05 * 3.0)


def test_a_brake_that_slips_says_that_it_holds_and_one_that_is_open_says_so():
    for kind, engaged in (("brake_slip", True), ("brake_open", False)):
        bench = Bench(supervision_time=0.0)
        bench.inject(kind, 0.02)
        bench.run(2.0, brake=True)
        assert bench.state.payout == pytest.approx(0.04)
        assert bench.state.brake is engaged


def test_a_brake_that_does_not_open_keeps_the_drum_where_it_is():
    bench = Bench(supervision_time=0.0)
    bench.inject("brake_shut", duration=2.0)
    bench.run(2.0, rate=0.5)
    assert (bench.state.payout, bench.state.brake) == (0.0, True)
    bench.run(2.0, rate=0.5)
    assert bench.state.payout_rate == pytest.approx(0.5, rel=1e-3), "afterwards it follows"


def test_pressure_that_falls_and_comes_back_bounds_the_speed_and_says_so():
    bench = Bench(speed_limit=2.0)
    bench.inject("low_pressure", 0.1, duration=3.0)
    bench.run(2.9, rate=0.5)
    assert bench.state.payout_rate == pytest.approx(0.1 * 2.0, rel=1e-3)
    assert bench.state.limits_hit & WinchLimit.PRESSURE
    bench.run(2.0, rate=0.5)
    assert bench.state.payout_rate == pytest.approx(0.5, rel=1e-3)
    assert not bench.state.limits_hit & WinchLimit.PRESSURE


def drum(**parameters):
    """Return a drum alone, and its faults."""
    faults = FaultSchedule(FaultParameters(), name="winch", device="winch")
    return FaultyDrum(WinchParameters(**parameters), faults), faults


AT_3 = DriveState(3.0, 0.5, 0.0, 0.0, 0.0, WinchLimit.SPEED, brake=False)


def moved(of, *, is_at_rest=False, is_held=False, tension=TENSION, duration=1.0, state=AT_3):
    return of.moved(state, is_at_rest=is_at_rest, is_held=is_held, time=10.0, duration=duration, tension=tension)


@pytest.mark.parametrize("is_at_rest", [False, True])
def test_a_sound_drum_does_what_the_drive_does_and_its_brake_says_what_it_does(is_at_rest):
    sound, _ = drum()
    assert sound.is_brake_engaged
    order = DriveCommand(0.5, 7.0)
    assert sound.ordered(order, 10.0, 3.0) is order
    assert moved(sound, is_at_rest=is_at_rest) is AT_3
    assert sound.is_brake_engaged is is_at_rest


def test_a_drum_that_turns_the_other_way_goes_as_far_from_where_it_is_to_the_other_side():
    """At 3 m, ordered to 7 m at 0.5 m/s: to -1 m. What the load has slipped is none of the drive's way."""
    reversed_one, faults = drum()
    faults.inject("reverse", start=0.0)
    assert reversed_one.ordered(DriveCommand(0.5, 7.0), 10.0, 3.0) == DriveCommand(-0.5, -1.0)
    faults.inject("creep", start=0.0, magnitude=0.25)
    assert moved(reversed_one, duration=2.0).payout == 3.5
    # the drive is at 3 m where the rope is at 3.5 m, and 7 m of rope are 6.5 m of it
    assert reversed_one.ordered(DriveCommand(0.5, 7.0), 10.0, 3.5) == DriveCommand(-0.5, -0.5)


@pytest.mark.parametrize(
    ("kind", "is_at_rest", "slips", "is_engaged"),
    [
        ("creep", False, True, False),
        ("creep", True, False, True),
        ("brake_slip", False, False, False),
        ("brake_slip", True, True, True),
        ("brake_open", False, False, False),
        ("brake_open", True, True, False),
        ("brake_shut", False, False, True),
        ("brake_shut", True, False, True),
    ],
)
def test_the_load_pays_out_where_nothing_holds_it_and_only_then(kind, is_at_rest, slips, is_engaged):
    """Held by the drive as well it stays; what the brake's switch says is the same."""
    faulty, faults = drum()
    faults.inject(kind, start=0.0, magnitude=0.25)
    slack = moved(faulty, is_at_rest=is_at_rest, tension=0.0)
    assert (slack.payout, slack.payout_rate) == (3.0, 0.5)
    state = moved(faulty, is_at_rest=is_at_rest, duration=2.0)
    assert (state.payout, state.payout_rate) == ((3.5, 0.75) if slips else (3.0, 0.5))
    assert state.limits == WinchLimit.SPEED
    assert faulty.is_brake_engaged is is_engaged
    if is_at_rest:
        assert moved(faulty, is_at_rest=True, is_held=True, duration=2.0).payout_rate == 0.5
        assert faulty.is_brake_engaged is is_engaged
    assert faulty.ordered(DriveCommand(0.1), 10.0, 3.0).brake is (kind == "brake_shut")
    assert faulty.ordered(DriveCommand(0.1, brake=True), 10.0, 3.0).brake


@pytest.mark.parametrize(
    ("rate", "given", "is_limited"), [(0.5, 0.5, False), (0.51, 0.5, True), (-0.51, -0.5, True), (-0.4, -0.4, False)]
)
def test_low_pressure_limits_the_speed_either_way_to_its_share(rate, given, is_limited):
    weak, faults = drum(speed_limit=2.0)
    faults.inject("low_pressure", start=0.0, duration=20.0, magnitude=0.25)
    assert moved(weak).limits == WinchLimit.SPEED, "before any order"
    assert weak.ordered(DriveCommand(rate), 10.0, 3.0).payout_rate == given
    assert moved(weak).limits == WinchLimit.SPEED | (WinchLimit.PRESSURE if is_limited else WinchLimit.NONE)
    assert weak.ordered(DriveCommand(9.0), 30.0, 3.0).payout_rate == 9.0, "afterwards there is no such limit"
    assert moved(weak).limits == WinchLimit.SPEED


@pytest.mark.parametrize(
    ("kind", "magnitude", "brake", "within", "words"),
    [
        ("reverse", 0.0, False, SUPERVISED + 3.0 * LAG, "turns against the command"),
        ("brake_shut", 0.0, False, SUPERVISED + 2.0 * TICK, "the brake does not open"),
        ("brake_open", 0.0, True, SUPERVISED + 2.0 * TICK, "the brake does not engage"),
        ("brake_open", 0.05, True, SUPERVISED + 2.0 * TICK, "the brake does not"),
        ("brake_slip", 0.05, True, 0.05 / 0.05 + 2.0 * TICK, "the brake does not hold: the drum has moved by +0.05 m"),
    ],
)
def test_the_supervision_of_the_drive_trips_within_its_time_and_names_the_fault(kind, magnitude, brake, within, words):
    bench = Bench(supervision_time=SUPERVISED)
    bench.run(1.0, rate=0.3, brake=brake)
    bench.inject(kind, magnitude)
    assert bench.run(4.0, rate=0.3, brake=brake) <= within
    assert bench.state.fault is WinchFault.DRIVE
    assert words in bench.winch.supervised


@given(st.lists(st.floats(-1.0, 1.0), min_size=10, max_size=60))
def test_a_sound_drum_is_never_stopped_whatever_is_ordered(rates):
    bench = Bench(supervision_time=SUPERVISED)
    for rate in rates:
        assert bench.run(2.0 * TICK, rate=rate) == 2.0 * TICK
    assert bench.state.fault is WinchFault.NONE


def test_a_drive_is_supervised_unless_it_is_said_that_nothing_does_so():
    """The table of hazards names reactions that need it."""
    bench = Bench()
    bench.run(1.0, brake=True)
    bench.inject("brake_slip", 0.5)
    rest(bench, 10.0)
    assert bench.state.fault is WinchFault.DRIVE
    assert bench.state.payout < SLIP + 2.0 * TICK * 0.5 + 1e-6


@pytest.mark.parametrize("kind", ["freeze", "jump", "scale", "nan", "spike"])
def test_an_encoder_that_fails_is_no_fault_of_drum_or_brake(kind):
    bench = Bench()
    bench.winch.encoder.faults.inject(kind, start=2.0, magnitude=0.4, duration=8.0)
    assert bench.run(6.0, rate=0.2) == 6.0
    bench.run(6.0, brake=True)
    assert bench.state.fault is WinchFault.NONE


def test_a_drum_at_the_end_of_its_range_or_below_its_dead_zone_is_no_fault():
    at_end = Bench(payout_maximum=1.0)
    at_end.run(10.0, rate=0.3)
    assert (at_end.state.fault, at_end.state.payout) == (WinchFault.NONE, pytest.approx(1.0, abs=1e-3))
    still = Bench(speed_deadband=0.2)
    still.run(10.0, rate=0.15)
    assert (still.state.fault, still.state.payout) == (WinchFault.NONE, 0.0)


def test_the_alarm_of_a_drive_that_its_open_brake_has_tripped_does_not_say_that_the_brake_is_on():
    bench = Bench(supervision_time=SUPERVISED)
    bench.run(1.0, brake=True)
    bench.inject("brake_open", 0.1)
    assert bench.run(5.0, brake=True) < SUPERVISED
    state = bench.state
    alarm = str(fault_alarm(state.fault, state.release, brake=state.brake, cause=bench.winch.supervised))
    assert alarm.startswith("WINCH_DRIVE_FAULT (high): the winch has stopped (drive: the brake does not engage")
    assert "The brake is open;" in alarm


SLIP = 0.05
"""Motion under an engaged brake that is a slip [m]; one tick passes before it is found, one before it is acted upon."""


def slipping(kind="brake_slip", speed=0.1, **parameters):
    """Return a supervised winch that rests under a brake that has begun not to hold, after a time without commands."""
    bench = Bench(supervision_time=SUPERVISED, **parameters)
    bench.run(1.0, brake=True)
    bench.inject(kind, speed)
    rest(bench, 20.0)
    return bench


def rest(bench, seconds):
    for _ in range(round(seconds / TICK)):
        bench.winch.step(bench.winch.tick, None, TENSION)


@pytest.mark.parametrize("drive", ["speed_servo", "electric", "pump_controlled", "valve_controlled"])
@pytest.mark.parametrize("kind", ["brake_slip", "brake_open"])
@pytest.mark.parametrize("speed", [0.02, 0.1, 0.4])
def test_a_drum_that_slips_past_its_brake_is_held_by_the_drive_without_any_command(drive, kind, speed):
    bench = slipping(kind, speed, drive=drive)
    # two ticks until it is found and held, and what the leakage of a pump lets it sag until its loop carries the load
    # a brake that says it is open is found after the supervision's time as well
    least = SLIP if kind == "brake_slip" else min(SLIP, SUPERVISED * speed)
    assert least < bench.state.payout < SLIP + 2.0 * TICK * speed + 0.02
    assert bench.state.payout_rate == pytest.approx(0.0, abs=1e-4)
    assert (bench.state.fault, bench.state.brake) == (WinchFault.DRIVE, kind == "brake_slip")
    assert bench.winch.supervised.endswith("; the drive holds it")


@pytest.mark.parametrize("speed", [0.05, 0.103, 0.3])
def test_a_drum_whose_brake_stays_open_as_it_stops_is_held_by_the_drive(speed):
    """It never stood: from 0.1 m/s on nothing was found, and below that the drive tripped and held nothing."""
    bench = Bench()
    bench.run(3.0, rate=-0.4)
    bench.inject("brake_open", speed)
    bench.run(5.0, brake=True)
    rest(bench, 5.0)
    assert (bench.state.fault, bench.state.payout_rate) == (WinchFault.DRIVE, 0.0)
    assert bench.winch.supervised.endswith("; the drive holds it")


def test_a_load_held_by_the_drive_stays_where_brake_requests_come_and_follows_once_it_is_released():
    bench = slipping()
    held = bench.state.payout
    bench.run(TICK, brake=True)
    rest(bench, 5.0)
    assert bench.state.payout == held
    assert bench.state.release is WinchRelease.COMMAND
    bench.run(2.0, rate=-0.3)
    assert bench.state.fault is WinchFault.NONE
    assert bench.state.payout_rate == pytest.approx(-0.3, rel=1e-3)
    before = bench.state.payout
    bench.run(5.0, brake=True)
    rest(bench, 5.0)
    assert bench.state.fault is WinchFault.DRIVE, "the brake still slips"
    # it stops with 1.5 m/s^2 from 0.3 m/s, and slips once more
    assert bench.state.payout == pytest.approx(before - 0.3**2 / 3.0 + SLIP, abs=0.02)


@pytest.mark.parametrize("kind", ["drive", "emergency_stop"])
def test_a_drive_without_power_holds_nothing(kind):
    bench = slipping()
    bench.inject(kind)
    held = bench.state.payout
    rest(bench, 10.0)
    assert bench.state.payout == pytest.approx(held + 10.0 * 0.1, abs=0.01)
    assert "holds" not in bench.winch.supervised


def test_after_an_emergency_stop_that_is_over_a_slip_is_not_held_without_a_release():
    bench = Bench(supervision_time=SUPERVISED)
    bench.run(1.0, brake=True)
    bench.inject("emergency_stop", duration=1.0)
    rest(bench, 2.0)
    bench.inject("brake_slip", 0.1)
    rest(bench, 10.0)
    assert bench.state.payout == pytest.approx(1.0, abs=0.01)
