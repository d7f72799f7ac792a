"""Every field of the interface is for something: those that a ship's device sends drive the controller, and no message
has a field that nothing fills.

Readings of a loop that compensates are given to its controller once more, from one tick on with one field changed. What
the field is for stands in its message's comment. A recorded run shows which fields are filled; of the others, which a
calm sea does not need, the test is named that has them.
"""

import multiprocessing
from dataclasses import replace
from pathlib import Path

import heave_msgs.msg
import pytest
from heave_bags.mcap.reader import Bag
from heave_bringup import ClosedLoop, load_scenario, loop_parameters
from heave_msgs.msg import LoadCell, MruSample, WinchState
from heave_node.crane.pose import pose_message
from heave_node.interface.codes import MruStatus
from heave_node.interface.sensors import WireReading
from rclpy.serialization import deserialize_message

FROM, TICKS = 580, 100
"""The loop compensates from tick 540 on."""


def more(value):
    return value + 1


CHANGES = {
    "mru.stamp": more,
    "mru.heave": more,
    "mru.heave_rate": more,
    "mru.heave_sigma": more,
    "mru.heave_rate_sigma": more,
    "mru.status": lambda _: int(MruStatus.INVALID),
    "winch.stamp": more,
    "winch.encoder_payout": more,
    "winch.brake": lambda brake: not brake,
    "winch.fault": more,
    "winch.command_sequence": lambda _: 1,
    "winch.limits_hit": more,
    "load_cell.stamp": more,
    "load_cell.tension": lambda tension: 1.2 * tension,
}

ELSEWHERE = {
    **dict.fromkeys(("mru.roll", "mru.pitch", "mru.heave_acceleration"), "extras/devices/test/test_tip_carry.py"),
    **dict.fromkeys(("mru.sequence", "winch.release"), "bringup/test/test_check.py"),
    **dict.fromkeys(("winch.payout_rate", "winch.payout_acceleration"), "bags/test/test_kpi.py"),
    **dict.fromkeys(("winch.payout", "winch.tension", "winch.power"), "cable_sim_node/test/test_virtual_winch.py"),
    "winch.encoder_payout_rate": "bags/test/test_sea_trial.py",
    "load_cell.tension_sigma": "node_base/test/test_sensors.py",
}
"""Fields that the controller does not go by here: the tests of what reads them."""
MESSAGES = {"mru": MruSample, "winch": WinchState, "load_cell": LoadCell}


@pytest.fixture(scope="module")
def readings():
    settings = [
        "all.duration=36",
        "wave_vessel.ramp=2",
        "winch_controller.sensors.use=[mru, depth, encoder, load_cell]",
    ]
    parameters = loop_parameters(load_scenario("b2_calm_300", settings=settings))
    closed, kept = ClosedLoop(parameters, has_adviser=False), []
    step = closed.controller.step

    def keep(tick, given):
        kept.append((tick, given))
        return step(tick, given)

    closed.controller.step = keep
    closed.run()
    again = ClosedLoop(parameters, has_adviser=False).controller
    for tick, given in kept[:FROM]:
        again.step(tick, given)
    return again, kept[FROM : FROM + TICKS]


def answers(readings, change):
    """Return what the controller does and says from the changed tick on, in a process that begins with its memory."""
    mine, theirs = multiprocessing.Pipe()

    def work():
        controller, kept = readings
        found = []
        for tick, given in kept:
            one = controller.step(tick, change(given))
            found.append(repr((one.report, one.order, one.observations)))
        theirs.send(found)

    child = multiprocessing.get_context("fork").Process(target=work)
    child.start()
    theirs.close()  # so that a child that fails is an end, not a wait
    found = mine.recv()
    child.join()
    return found


def changed(given, place, change):
    part, name = place.split(".")
    name = {"stamp": "time", "tension": "value"}.get(name, name)
    if part == "load_cell":
        cells = tuple(one._replace(**{name: change(getattr(one, name))}) for one in given.scalar.get(part, ()))
        return replace(given, scalar={**given.scalar, part: cells})
    one = given.winch if part == "winch" else given.mru[0]
    new = one._replace(**{name: change(getattr(one, name))})
    return replace(given, **({"winch": new} if part == "winch" else {"mru": (new,)}))


@pytest.fixture(scope="module")
def plain(readings):
    return answers(readings, lambda given: given)


@pytest.mark.parametrize("place", CHANGES)
def test_a_field_that_a_device_sends_drives_something(place, readings, plain):
    assert answers(readings, lambda given: changed(given, place, CHANGES[place])) != plain


def test_no_field_of_what_a_device_sends_is_without_a_test():
    fields = {f"{part}.{name}" for part, kind in MESSAGES.items() for name in kind.get_fields_and_field_types()}
    named = {place.replace(".stamp", ".header") for place in CHANGES} | set(ELSEWHERE)
    assert fields == named
    for place, file in ELSEWHERE.items():
        assert place.partition(".")[2] in (Path(__file__).parents[1] / file).read_text(encoding="utf-8"), place


ROOT = Path(__file__).parents[1]
PROTOCOL, ADVICE = "node_base/heave_node/*/*.py", "winch_controller_node/*/advice/messages.py"
OTHERS = {
    "CableState": "cable_sim_node/test/test_conversions.py",
    "ControllerState": "tests/test_every_field.py",
    "CompensationKpi": "winch_controller_node/test/test_beliefs_in_force.py",
    "HeavePreview": "wave_vessel_node/test/test_preview.py",
    "SeaState": "tests/test_running_sea.py",
    "SeaStateEstimate": "wave_vessel_node/wave_vessel_node/conversions.py",
    "SensorHealth": "winch_controller_node/test/test_sensor_health.py",
    "WinchCommand": "bringup/test/test_position_loop.py",
    **dict.fromkeys(("AdoptedState", "Belief", "Beliefs", "DesignArrays", "EncoderScale", "Finding"), ADVICE),
    **dict.fromkeys(("NamedArray", "NamedTexts", "Observations"), ADVICE),
    **dict.fromkeys(("TickDone", "TickJoin", "TickPart", "TickRoster", "TickStart", "TickStatus"), PROTOCOL),
}
"""Messages that ten seconds of a calm sea do not send, or not with all of their fields: the tests of the others, or
what packs and reads all fields at once: estimate of the sea, advice, and the tick protocol, without which no run is.
"""


def note_filled(found, name, message):
    """Add to `found` whether each field of a `message` of the type called `name`, and of those in it, is filled."""
    kind = getattr(heave_msgs.msg, name)
    plain = kind()
    for field, form in kind.get_fields_and_field_types().items():
        value, empty = getattr(message, field), getattr(plain, field)
        inner = form.removeprefix("sequence<").partition(">")[0].partition(",")[0].partition("heave_msgs/")[2]
        for one in (value if form.startswith("sequence<") else [value]) if inner else []:
            note_filled(found, inner, one)
        found[f"{name}.{field}"] = found.get(f"{name}.{field}", False) or repr(value) != repr(empty)


@pytest.fixture(scope="module")
def filled(calm_bag):
    found = {}
    pose = pose_message(WireReading(1, tuple(map(float, range(1, 9)))))
    note_filled(found, "CranePose", deserialize_message(pose, heave_msgs.msg.CranePose))
    bag = Bag(calm_bag)
    for raw, message in bag.decoded():
        package, _, name = bag.topics[raw.topic].type.split("/")
        if package == "heave_msgs":
            note_filled(found, name, message)
    return found


def test_every_field_of_every_message_is_filled_in_a_run_or_in_a_test(filled):
    """A field that no run and no test fills is none of the interface."""
    kinds = {name: getattr(heave_msgs.msg, name) for name in dir(heave_msgs.msg)}
    fields = {
        f"{name}.{field}"
        for name, kind in kinds.items()
        if hasattr(kind, "get_fields_and_field_types")
        for field in kind.get_fields_and_field_types()
    }
    of_devices = {f"{kind.__name__}.{name}" for kind in MESSAGES.values() for name in kind.get_fields_and_field_types()}
    missing = sorted(fields - of_devices - {place for place, is_filled in filled.items() if is_filled})
    assert len(fields) - len(missing) > 100
    text = {name: "".join(map(Path.read_text, ROOT.glob(files))) for name, files in OTHERS.items()}
    assert not [place for place in missing if place.partition(".")[2] not in text[place.partition(".")[0]]]


def test_what_the_controller_does_at_a_limit_is_in_its_state():
    """ControllerState.active_limits, solver_status, solver_iterations: of a plan at the speed limit of the winch.

    With it authority, depth_set_point, payout_rate_set_point: of a winch that moves.
    """
    settings = ["all.duration=36", "wave_vessel.ramp=2", "winch_controller.law=mpc", "system.winch.speed_limit=0.2"]
    closed, states = ClosedLoop(loop_parameters(load_scenario("b2_calm_300", settings=settings))), []
    closed.run(lambda _, outputs: states.append(outputs.report))
    assert any("speed" in state.active_limits for state in states)
    assert max(state.solver_iterations for state in states) > 0
    assert any(state.solver_status for state in states)
