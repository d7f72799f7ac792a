"""The reflex about the encoder in a controller: what is found before a tick, and what is void from then on."""

import math

import numpy as np
import pytest
from heave_core.sense_table import Level, Reason
from heave_core.watch_table import ReflexNews
from winch_controller_node.core.component import WinchController
from winch_controller_node.core.estimation.sense_design import SENSOR
from winch_controller_node.core.supervision.modes import MODES, Mode
from winch_controller_node.core.supervision.watch.drum_watch import ORDERED_TIME
from winch_controller_node.core.supervision.watch.encoder_reflex import CONSTANTS, LOST_TIME
from winch_controller_node.interface.readings import Measurements
from winch_controller_node.node_parameters import WinchControllerParameters

from tests.core_parts import COUNT, part

DT = 0.05
NOTHING = 0
SEPARATED = CONSTANTS["separated"]


class Watched:
    """A controller whose winch moves, and its encoder as a test states it."""

    def __init__(self, mode=Mode.COMPENSATING, **parameters):
        self.controller = WinchController(WinchControllerParameters(**parameters), tick_period=DT)
        self.controller.step(1, Measurements())
        self.gate = self.controller.observer.state[0]["gates"][SENSOR["encoder"]]
        self.encoder = self.controller.observer.state[0]["encoder"]
        self.guard = self.controller._supervisor.guard.core.state[0]
        self.reflex, self.drum = self.controller._encoder, self.controller._winch.drum
        self.go_to(mode)
        self.read()
        self.number = 1

    def go_to(self, mode):
        """Be in a `mode`."""
        self.controller.modes.state["mode"] = MODES.index(mode)

    def read(self, level=Level.SENSOR_OK, reason=Reason.GOOD):
        """Have the encoder read so."""
        self.gate["level"], self.gate["reason"] = level, reason

    def tick(self, count=1):
        """Return what is found before each of so many ticks."""
        found = []
        for _ in range(count):
            self.number += 1
            self.controller._control.given[0] = self.number
            found.append(part("watch_encoder", result=COUNT)(self.controller._control._at))
        return found[0] if count == 1 else found

    def turn(self, seconds, factor):
        """Order waves, the encoder reading `factor` times the nominal drum, up to before a look; return its payouts."""
        winch, payout, rate = self.controller.parameters.winch, 0.0, 0.0
        share = -math.expm1(-DT / winch.time_constant)
        delayed, payouts = [0.0] * round(winch.command_delay / DT), []
        for place in range(round(seconds / DT)):
            ordered = 0.5 * math.sin(0.7 * DT * place)
            delayed.append(ordered)
            before, rate = rate, rate + share * (delayed.pop(0) - rate)
            payout += DT * 0.5 * (before + rate)
            payouts.append(payout)
            self.drum.add(0.0, ordered, factor * payout)
        self.number += self.number % 2 == 0
        return payouts


def lost_for(watched, seconds):
    watched.read(Level.SENSOR_LOST, Reason.STALE)
    watched.tick(round(seconds / DT))
    watched.read()
    return watched.tick()


@pytest.mark.parametrize(("time", "is_found"), [(LOST_TIME - DT, False), (LOST_TIME, True), (9.0, True)])
def test_a_drum_is_looked_for_once_an_encoder_that_was_lost_for_long_is_back(time, is_found):
    watched = Watched()
    assert lost_for(watched, time) == (ReflexNews.ENCODER_FOUND if is_found else NOTHING)
    assert watched.tick() == NOTHING


def test_while_an_encoder_is_lost_the_depth_sensor_is_not_held_against_the_estimate():
    watched = Watched()
    watched.read(Level.SENSOR_LOST, Reason.STALE)
    for count, is_held in ((round(LOST_TIME / DT), True), (1, False)):
        watched.guard["mismatch"]["square"] = 1.0
        watched.tick(count)
        assert bool(watched.guard["mismatch"]["square"] > 0.0) is is_held


@pytest.mark.parametrize(("lasts", "count"), [(0.325, 7), (0.0, 0)])
def test_after_a_jump_the_record_is_void_until_orders_in_the_new_count_act(lasts, count):
    """So long as an order of before acts: a speed servo without a position loop goes by none."""
    watched = Watched()
    watched.reflex.take_delay(lasts)
    watched.turn(5.0, 1.0)
    watched.guard["drum_share"] = 0.3
    watched.encoder["jumped_at"] = (watched.number + 1) * DT
    assert watched.tick(20) == [ReflexNews.COUNT_STEPPED] * count + [NOTHING] * (20 - count)
    assert bool(watched.guard["drum_share"] == 0.0) is (count > 0)
    assert bool(watched.controller._winch._core.state["drum"]["readings"][0] == 0) is (count > 0)


@pytest.mark.parametrize("mode", [Mode.COMPENSATING, Mode.MANUAL, Mode.STANDBY, Mode.STOPPED])
def test_a_count_that_stands_is_disputed_once_where_no_brake_holds_the_drum(mode):
    watched = Watched(mode)
    watched.read(Level.SENSOR_LOST, Reason.FROZEN)
    is_braked = mode in (Mode.STANDBY, Mode.STOPPED)
    assert watched.tick() == (NOTHING if is_braked else ReflexNews.COUNT_DISPUTED)
    assert watched.tick() == NOTHING


@pytest.mark.parametrize(
    ("nats", "is_judged", "is_drive"),
    [
        (SEPARATED + 0.1, True, True),
        (-SEPARATED - 0.1, True, False),
        (SEPARATED - 0.1, False, False),
        (0.0, False, False),
    ],
)
def test_drive_or_encoder_is_named_by_enough_evidence_and_a_drive_at_fault_moves_no_more(nats, is_judged, is_drive):
    watched = Watched()
    watched.read(Level.SENSOR_LOST, Reason.FROZEN)
    watched.tick()
    watched.reflex.state["nats"] = nats
    assert watched.tick() == (ReflexNews.COUNT_JUDGED if is_judged else NOTHING)
    assert watched.reflex.is_unresolved is is_drive
    assert bool(watched.reflex.state["is_named"][0]) is is_judged
    assert watched.tick() == NOTHING, "it is named once"


def test_a_count_that_agrees_again_ends_the_dispute_and_takes_back_what_was_named_unless_that_stays_unresolved():
    watched = Watched()
    watched.read(Level.SENSOR_LOST, Reason.FROZEN)
    watched.tick()
    watched.read()
    assert watched.tick() == ReflexNews.COUNT_AGREES
    assert watched.tick() == NOTHING
    for is_unresolved in (0, 1):
        watched.reflex.state["is_named"], watched.reflex.state["is_unresolved"] = 1, is_unresolved
        watched.tick()
        assert watched.reflex.state["is_named"][0] == is_unresolved


@pytest.mark.parametrize("mode", [Mode.COMPENSATING, Mode.FADE_OUT])
def test_a_reversed_encoder_is_set_aside_and_the_drum_is_where_it_was_ordered(mode):
    watched = Watched(mode)
    payouts = watched.turn(8.0, -1.0)
    assert watched.tick() == ReflexNews.ENCODER_REFUTED
    assert watched.reflex.state["compares"][0] == 1
    # from where it was read 0.8 s ago it has gone as it was ordered
    before, now = payouts[-1 - round(ORDERED_TIME / DT)], payouts[-1]
    assert watched.reflex.state["payout"][0] == pytest.approx(-before + (now - before), abs=0.02)
    assert not watched.reflex.alarm.name.endswith("scale")


def test_an_encoder_that_reads_what_a_nominal_winch_was_ordered_refutes_the_beliefs():
    """The winch is assumed to be reversed: by that, and not by the parameters, is the encoder."""
    watched = Watched()
    watched.drum._core.design["assumed"]["gain"] = -1.0
    watched.turn(8.0, 1.0)
    assert watched.tick() == ReflexNews.BELIEFS_REFUTED
    assert watched.reflex.state["compares"][0] == 0


def test_an_assumed_scale_of_the_encoder_is_left_out_of_what_it_reads_of_a_nominal_winch():
    """Twice what was ordered, of an encoder that is assumed to read twice as much: the drum goes as it was read."""
    watched = Watched()
    watched.drum._core.design["assumed"]["gain"] = -1.0
    watched.encoder["scale"] = 2.0
    watched.turn(8.0, 0.5)
    assert watched.tick() == ReflexNews.BELIEFS_REFUTED


def test_one_that_is_aside_and_reads_what_was_ordered_is_used_again_and_the_drum_is_found_by_it():
    watched = Watched()
    watched.controller.observer.exclude("encoder")
    watched.turn(8.0, 1.0)
    watched.encoder["value"], watched.encoder["offset"] = 0.1, 5.0
    assert watched.tick() == ReflexNews.ENCODER_FOUND
    assert watched.controller.observer.excluded == ""
    assert watched.encoder["offset"] == 0.0, "the drum stands at 0, and the count is back near it"


@pytest.mark.parametrize(
    "why", ["standby", "manual", "another sensor is aside", "winch is not identified", "no look is due"]
)
def test_nothing_is_looked_at(why):
    watched = Watched(
        {"standby": Mode.STANDBY, "manual": Mode.MANUAL}.get(why, Mode.COMPENSATING),
    )
    watched.turn(8.0, -1.0)
    if why == "another sensor is aside":
        watched.controller.observer.exclude("depth")
    if why == "winch is not identified":
        watched.controller._control.active["identifies_winch"] = 0
    watched.number += why == "no look is due"
    assert watched.tick() == NOTHING
    assert np.all(watched.reflex.state["looks"] == 0)


def test_the_filter_that_goes_by_the_count_of_an_encoder_that_is_aside_stays_until_it_is_judged():
    watched = Watched()
    watched.controller.observer.exclude("encoder")
    watched.reflex.state["compares"] = 1
    assert watched.tick(5) == [NOTHING] * 5
    watched.reflex.state["nats"] = -SEPARATED - 0.1
    assert watched.tick() == ReflexNews.COUNT_JUDGED
