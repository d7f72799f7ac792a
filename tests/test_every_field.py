"""Every field that a ship's device sends drives something: changed, it changes what the controller does or says.

Readings of a loop that compensates are given to its controller once more, from one tick on with one field changed. What
the field is for stands in its message's comment.
"""

import multiprocessing
from dataclasses import replace
from pathlib import Path

import pytest
from heave_bringup import ClosedLoop, load_scenario, loop_parameters
from heave_msgs.msg import LoadCell, MruSample, WinchState
from heave_node.interface.codes import MruStatus

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
