"""A winch behind Modbus/TCP, OPC UA and UDP, without a run: its orders, its reports, and what ends it.

The PLC is a program of its own with the stock servers of pymodbus and asyncua; the test plays the controller.
"""

import time
from contextlib import ExitStack

import pytest
from heave_bringup.errors import CommandError
from heave_devices.adapt.device import LiveDevice
from heave_devices.adapt.report import health_of
from heave_devices.bench.wiggle import wiggle
from heave_devices.maps.device_map import device_map_of
from heave_msgs.msg import WinchCommand
from heave_node.files.bounded_yaml import parse_yaml
from heave_node.interface.codes import WinchFault, WinchRelease
from heave_node.ros.diagnostics import Level

from tests.adapt_fakes import Node
from tests.plc import KINDS, SPOILT, emulated

PAUSE = 0.3
"""A test whose machine stood for longer [s] is done again: watchdogs of map and PLC wait for 0.5 s."""


class Bench:
    """A controller of twenty commands a second on one device."""

    def __init__(self, text):
        self.node = Node()
        self.device = LiveDevice(device_map_of("winch", parse_yaml(text)), self.node)
        self.number = 0
        self.began, self.pause = time.monotonic(), 0.0
        self.device.start()

    @property
    def states(self):
        return self.node.sent["winch/state"]

    def command(self, until, rate=0.0, brake=lambda: False, timeout=60.0):
        """Send commands until `until` holds."""
        began = time.monotonic()
        while not until():
            assert time.monotonic() - began < timeout, (self.states[-1:], health_of(self.device, {}))
            self.number += 1
            order = WinchCommand(sequence=self.number, payout_rate=rate, brake=brake())
            self.node.callbacks["winch/command"](order)
            self.wait(0.05)

    def drive(self, until, rate=0.0):
        """Send commands until `until` holds, as a controller does: with the brake while the newest state waits for it.

        So what a pause of this machine latches is released again.
        """
        self.command(until, rate, lambda: not self.states or self.states[-1].release == WinchRelease.BRAKE_REQUEST)

    def brake(self, until):
        self.command(until, brake=lambda: True)

    def wait(self, seconds):
        """Guard the winch, wait, and note the longest time between two guards [s]."""
        self.device.guard()
        now = time.monotonic()
        self.pause, self.began = max(self.pause, now - self.began), now
        time.sleep(seconds)

    def says(self, **fields):
        return lambda: (
            bool(self.states) and all(getattr(self.states[-1], name) == value for name, value in fields.items())
        )

    def release(self):
        """Take the winch from whatever it is in to where it follows, as a state from now on says."""
        seen = len(self.states)
        self.drive(lambda: len(self.states) > seen and self.says(brake=False, fault=0)())

    @property
    def health(self):
        return health_of(self.device, {})


@pytest.fixture(scope="module")
def plc_of():
    """Return a function that gives the PLC of a kind as it is at its start: to start one takes two seconds."""
    running = {}
    with ExitStack() as stack:

        def give(kind):
            if kind not in running:
                running[kind] = stack.enter_context(emulated(kind))
            running[kind].begin_anew()
            return running[kind]

        yield give


@pytest.fixture(params=KINDS)
def plc(request, plc_of):
    """The PLC of each kind; of UDP one of its own, whose datagrams are spoilt by the same draws in each test."""
    if request.param != "udp":
        yield plc_of(request.param)
        return
    with emulated("udp", *SPOILT) as own:
        yield own


@pytest.fixture
def bench_of():
    benches = []

    def make(text):
        benches.append(Bench(text))
        return benches[-1]

    yield make
    for bench in benches:
        bench.device.close()


def test_a_winch_behind_each_protocol_moves_as_it_is_told(plc, bench_of):
    bench = bench_of(plc.text_of_map())
    bench.brake(lambda: bench.states)
    assert bench.states[-1].brake
    before = plc.drum()["position"]
    bench.release()
    bench.drive(lambda: bench.states[-1].encoder_payout > 0.1 and bench.states[-1].encoder_payout_rate > 0.19, rate=0.2)
    bench.brake(bench.says(brake=True))
    drum = plc.drum()
    moved = before - drum["position"]
    assert moved == pytest.approx(bench.states[-1].encoder_payout, abs=2e-4), "it counts hauling in, in 0.1 mm"
    assert drum["fastest"] == pytest.approx(0.2, rel=0.05)
    if plc.kind == "udp":
        counters = bench.device.counters
        assert min(counters.checksum_errors, counters.lost, counters.repeated + counters.late) > 0


def test_a_plc_whose_program_stands_is_not_used_and_must_be_released_again(plc, bench_of):
    bench = bench_of(plc.text_of_map())
    bench.release()
    plc.tell("halt")
    bench.command(lambda: bench.health.level is Level.STALE, rate=0.1)
    count = len(bench.states)
    words = "no reading for" if plc.kind == "udp" else "watchdog has not counted for"
    bench.command(lambda: bench.device.orders.handshake.fault and words in bench.health.message, rate=0.1)
    while plc.drum()["enable"]:
        bench.wait(0.05)
    assert len(bench.states) == count, "what a standing program says is no state"
    plc.tell("go")
    bench.command(lambda: len(bench.states) > count, rate=0.1)
    assert bench.states[-1].fault == WinchFault.COMMAND_TIMEOUT
    bench.release()


def test_a_plc_that_refuses_is_told_in_one_line_and_held(plc, bench_of):
    bench = bench_of(plc.text_of_map())
    bench.release()
    plc.tell("refuse")
    words = {
        "modbus": "read input:0 to input:5: exception 4: server device failure",
        "opcua": "what it answers is invalid",
    }.get(plc.kind, "no reading for")
    timed_out = WinchFault.COMMAND_TIMEOUT
    bench.command(lambda: bench.device.orders.handshake.fault == timed_out and words in bench.health.message, rate=0.1)
    plc.tell("accept")
    bench.release()


def test_a_drive_that_trips_is_told_and_reset_by_the_controllers_release(plc, bench_of):
    bench = bench_of(plc.text_of_map())
    bench.release()
    plc.tell("trip")
    bench.command(bench.says(fault=int(WinchFault.DRIVE)), rate=0.1)
    bench.release()
    bench.drive(lambda: bench.states[-1].encoder_payout_rate > 0.05, rate=0.1)


def test_without_commands_the_drive_is_told_to_stop_and_its_own_watchdog_is_fed(plc, bench_of):
    bench = bench_of(plc.text_of_map())
    bench.pause = PAUSE
    while bench.pause >= PAUSE:
        bench.release()
        bench.drive(lambda: bench.states[-1].encoder_payout_rate > 0.05, rate=0.1)
        bench.pause, silent = 0.0, time.monotonic()
        while not bench.states[-1].brake or time.monotonic() < silent + 1.2:  # 0.5 s of the map, then 0.5 s of the PLC
            bench.wait(0.05)
    assert bench.states[-1].fault == WinchFault.COMMAND_TIMEOUT
    assert bench.device.adapter.newest["fault"] == 0.0, "the drive itself has not tripped: it was told to brake"


@pytest.mark.parametrize(
    ("kind", "change", "words"),
    [
        ("modbus", ("input:0:int32", "input:100:int32"), "exception 2: illegal data address: check table, address"),
        ("opcua", ("s=Winch.Position", "s=Winch.Place"), "BadNodeIdUnknown: check the node in the map"),
        ("opcua", ("s=Winch.Reset", "s=Winch.Resets"), "s=Winch.Resets: "),
    ],
)
def test_a_map_that_names_what_the_plc_does_not_have_is_told_in_one_line(kind, change, words, plc_of, bench_of):
    bench = bench_of(plc_of(kind).text_of_map().replace(*change))
    bench.brake(lambda: words in bench.health.message)
    assert bench.health.level is Level.ERROR


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("", ""), ""),
        (("brake: 'input:4.0'", "brake: 'input:4.9'"), "input:4.9 must read engaged before and after the move"),
        (("unit: ms}", "unit: s}"), "its own time runs 1e+03 times as fast as time passes: check unit and scale"),
        (("scale: 10.0, positive: in", "scale: 10.0, positive: out"), "reversed. Check positive"),
        (("scale: 10.0", "scale: 100.0"), "braked: "),
        (("word_order: big", "word_order: little"), "with word_order: big it moved by"),
        (("watchdog: 'input:5'", "watchdog: 'input:7'"), "watchdog has not counted for"),
        (("fault: 'input:4.1'", "fault: 'input:4.0'"), "the drive reports a trip"),
        (("'holding:3': watchdog", "'holding:3': brake"), "the map sends it no watchdog"),
        (
            ("'holding:3': watchdog", "'holding:3': brake\n    'holding:2.4': watchdog"),
            "and where the map sends its watchdog",
        ),
        (("'holding:2.0': enable", "'holding:2.2': enable"), "check the map's brake, and enable in the command"),
    ],
)
def test_a_move_of_millimetres_shows_a_wrong_sign_and_stops_at_a_wrong_scale(change, words, plc_of, bench_of):
    plc = plc_of("modbus")
    bench = bench_of(plc.text_of_map().replace(*change))
    bench.pause = PAUSE
    while bench.pause >= PAUSE:
        bench.pause, bench.began = 0.0, time.monotonic()
        try:
            verdicts = wiggle(bench.device, bench.wait, 0.02)
            found = "; ".join(verdict.words for verdict in verdicts if not verdict.is_good)
        except CommandError as error:
            found = str(error)
    assert words in found if words else found == "", found
    if not found:
        assert ("reset", False) in [(verdict.what, verdict.is_tried) for verdict in verdicts], "the drive was sound"
    assert plc.drum()["fastest"] < 0.12, "2 d / T is 0.01 m/s, and ten times as much is stopped at once"


def test_an_order_with_its_words_swapped_is_braked(plc_of, bench_of):
    """10 mm/s in 0.1 mm/s are 655 m/s then: the drive goes at its limit until the wiggle or the supervision sees it."""
    bench = bench_of(plc_of("modbus").text_of_map().replace("'holding:0:int32'", "'holding:0:int32:little'"))
    with pytest.raises(CommandError, match="heck unit and scale"):
        wiggle(bench.device, bench.wait, 0.02)


def test_a_drum_that_turns_against_the_command_is_held_within_the_time_of_its_supervision(plc_of, bench_of):
    text = plc_of("modbus").text_of_map()
    bench = bench_of(text.replace("scale: 10.0, positive: in", "scale: 10.0, positive: out"))
    bench.release()
    bench.command(lambda: bench.device.orders.handshake.fault == WinchFault.DRIVE, rate=0.1)
    assert "stopped: the drum turns against the command" in bench.health.message
    bench.command(bench.says(brake=True, fault=int(WinchFault.DRIVE)), rate=0.1)


def test_a_set_point_of_another_unit_is_held_at_once_and_says_scale(plc_of, bench_of):
    """0.1 mm/s written as 1 um/s: a hundred times the speed."""
    plc = plc_of("modbus")
    bench = bench_of(plc.text_of_map().replace("scale: 10.0, positive: in", "scale: 1000.0, positive: in"))
    bench.release()
    place = bench.states[-1].encoder_payout
    bench.command(lambda: bench.device.orders.handshake.fault == WinchFault.DRIVE, rate=0.003)
    assert "times as far as commanded: check unit and scale" in bench.health.message
    assert abs(bench.states[-1].encoder_payout - place) < 0.25
    bench.command(bench.says(brake=True, fault=int(WinchFault.DRIVE)), rate=0.003)
    assert "times as far" in bench.health.message, "the words stay"


@pytest.mark.parametrize("kind", ["modbus", "udp"])
def test_a_link_that_is_lost_holds_the_winch_until_the_controller_releases_it(kind, bench_of):
    with emulated(kind) as own:
        bench = bench_of(own.text_of_map())
        bench.release()
    bench.command(lambda: bench.device.orders.handshake.fault == WinchFault.COMMAND_TIMEOUT, rate=0.1)
    assert bench.health.level in (Level.ERROR, Level.STALE)
    assert "\n" not in bench.health.message


def test_an_order_that_does_not_fit_its_register_is_not_sent_and_holds_the_winch(plc_of, bench_of):
    plc = plc_of("modbus")
    bench = bench_of(plc.text_of_map().replace("scale: 10.0, positive: in}", "scale: 1.0e+9, positive: in}"))
    bench.release()
    bench.command(lambda: bench.device.orders.handshake.fault, rate=0.5)
    assert "holding:0:int32: -5e+11 does not fit int32: check unit and scale of the map" in bench.health.message
    assert plc.drum()["fastest"] == 0.0


def test_a_plc_that_restarts_and_counts_from_nought_is_told_and_held_and_counted_on(plc, bench_of):
    """By its clock where the map has it (Modbus, UDP), else by what no drum can do: 1 m within two readings."""
    bench = bench_of(plc.text_of_map())
    bench.release()
    bench.drive(lambda: bench.states[-1].encoder_payout > 1.0, rate=1.0)
    bench.brake(lambda: bench.says(brake=True)() and plc.drum()["fastest"] == 0.0)
    before = bench.states[-1].encoder_payout
    plc.tell("restart")
    bench.brake(bench.says(fault=int(WinchFault.DRIVE)))
    assert "the drum's count jumped by -1." in bench.health.message
    assert bench.states[-1].encoder_payout == pytest.approx(before, abs=1e-3), "the drum has not moved"
    bench.release()
    bench.drive(lambda: bench.states[-1].encoder_payout > before + 0.1, rate=0.2)
    assert bench.device.adapter.drum_count.jumps == 1
