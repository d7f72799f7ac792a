"""The service that injects faults: from the next tick on, in words, `clear` for every device."""

from types import SimpleNamespace

import pytest
from heave_msgs.srv import InjectFault
from heave_node.interface.faults import FaultParameters, FaultSchedule
from heave_node.ros.fault_service import FaultService

KINDS = {"depth": "sensor", "mru": "mru", "encoder": "encoder", "winch": "winch"}
PERIOD = 0.05


class Node(SimpleNamespace):
    """What the service needs of a node that is in tick 9."""

    def __init__(self):
        self.devices = {name: FaultSchedule(FaultParameters(), name=name, device=kind) for name, kind in KINDS.items()}
        super().__init__(name="simulator", run=SimpleNamespace(tick_period=PERIOD), next_tick=10)
        self.requests = []
        FaultService(self, lambda: self.devices)

    def create_service(self, kind, name, callback):
        assert (kind, name) == (InjectFault, "simulator/inject_fault")
        self.serve = callback

    def note_request(self, time, words):
        self.requests.append((time, words))

    def ask(self, device, kind, duration=0.0, magnitude=0.0):
        request = InjectFault.Request(device=device, kind=kind, duration=duration, magnitude=magnitude)
        return self.serve(request, InjectFault.Response())


@pytest.mark.parametrize(
    ("device", "kind"), [("depth", "gap"), ("mru", "restart"), ("encoder", "nan"), ("winch", "drive")]
)
def test_a_fault_begins_with_the_next_tick_and_clear_ends_it(device, kind):
    node = Node()
    answer = node.ask(device, kind)
    assert (answer.success, answer.message) == (True, f"{device}: {kind} from t = 0.500 s")
    faults = node.devices[device]
    assert not faults.is_active(kind, 9 * PERIOD)
    assert faults.is_active(kind, 10 * PERIOD)
    node.next_tick = 20
    assert node.ask(device, "clear").success
    assert [faults.is_active(kind, tick * PERIOD) for tick in (19, 20)] == [True, False]


def test_a_fault_before_the_run_begins_with_its_first_tick():
    node = Node()
    node.next_tick = 1
    assert node.ask("depth", "gap", 0.1).message == "depth: gap from t = 0.050 s"


@pytest.mark.parametrize(
    ("device", "kind", "magnitude", "words"),
    [
        ("sonar", "gap", 0.0, "simulator has no device sonar; it has depth, mru, encoder, winch"),
        ("winch", "freeze", 0.0, "winch: a fault of kind freeze is unknown; known: gap, delay"),
        ("depth", "rate", 0.0, "depth: the magnitude of kind rate must be above 0 Hz; got 0"),
    ],
)
def test_what_cannot_be_is_refused_in_words(device, kind, magnitude, words):
    answer = Node().ask(device, kind, magnitude=magnitude)
    assert not answer.success
    assert answer.message.startswith(words)


def test_what_was_injected_is_reported_and_what_was_refused_is_not():
    node = Node()
    node.ask("mru", "freeze", 10.0)
    node.ask("winch", "brake_slip", magnitude=0.1)
    node.ask("sonar", "gap")
    node.ask("mru", "clear")
    assert node.requests == [
        (0.5, "fault of mru: freeze for 10 s"),
        (0.5, "fault of winch: brake_slip 0.1"),
        (0.5, "fault of mru: clear"),
    ]


def test_the_devices_of_now_are_asked_since_a_reset_makes_new_ones():
    node = Node()
    node.devices = {"depth": FaultSchedule(FaultParameters(), name="depth", device="sensor")}
    assert node.ask("depth", "gap").success
    assert not node.ask("mru", "gap").success
