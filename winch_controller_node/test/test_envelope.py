"""The envelope as the controller has it: its move beside the mean payout's, what it is given, what is sent for it."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario
from heave_core.envelope_table import Bit, Cause, Phase
from heave_core.law import put
from heave_core.law_table import LawKind
from hypothesis import given, settings
from hypothesis import strategies as st
from winch_controller_node.core.envelope import Asked, OrderEnvelope, _alarm, nominal_design
from winch_controller_node.core.envelope_alone import EnvelopeAlone
from winch_controller_node.core.supervision.modes import Mode
from winch_controller_node.interface.readings import Measurements, ScalarReading, WinchOrder, WinchReading
from winch_controller_node.laws import registry
from winch_controller_node.laws.law import LawCommand
from winch_controller_node.model.blocks import CableModel
from winch_controller_node.motion.trajectory import MeanPayout
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.envelope_node import WinchEnvelopeParameters

from tests.core_parts import change_order

TICK = 0.05
NOMINAL = WinchControllerParameters()
CABLE = CableModel(0.12, 0.02, stiffness=52e3, static_tension=37e3)

REQUEST = st.one_of(
    st.tuples(st.just("go"), st.floats(-30.0, 30.0), st.floats(0.0, 1.0)),
    st.tuples(st.just("drive"), st.floats(-0.5, 0.5), st.floats(0.01, 0.2)),
    st.tuples(st.just("halt"), st.floats(0.1, 1.0), st.just(0.0)),
    st.tuples(st.just("stop"), st.just(0.0), st.just(0.0)),
    st.tuples(st.just("stand"), st.just(0.0), st.just(0.0)),
)


def late_counts():
    """Yield the ticks of a drum that turns at 0.1 m/s, when its count was read, 0.25 s before, and the count."""
    for tick in range(40):
        time = tick * TICK - 0.25
        yield tick, time, 0.1 * max(time - NOMINAL.winch.command_delay - NOMINAL.winch.time_constant - 0.5 * TICK, 0.0)


def test_a_count_is_as_old_as_its_stamp():
    """As of now it is 2 cm behind that of the nominal drum."""
    move = MeanPayout(NOMINAL.move, tick_period=TICK).request
    behind = []
    for is_stamped in (True, False):
        envelope, most = OrderEnvelope(NOMINAL, CABLE, TICK), 0.0
        for tick, time, way in late_counts():
            raw = Measurements(winch=WinchReading(time if is_stamped else tick * TICK, way, 0.1, brake=False))
            asked = Asked(Mode.COMPENSATING, move, time=tick * TICK)
            envelope.step(raw, asked, WinchOrder(tick, 0.0, 0.1, False))
            most = max(most, -envelope.last.residual)
        behind.append(most)
    assert behind[0] < 0.007
    assert behind[1] > 0.015


def test_a_load_cell_that_has_jumped_is_off_until_it_jumps_back_or_an_operator_knows():
    """By half of the static tension: no load does that between two readings."""
    envelope, order = OrderEnvelope(NOMINAL, CABLE, TICK), WinchOrder(1, 0.0, 0.0, True)
    move = MeanPayout(NOMINAL.move, tick_period=TICK).request

    def read(share):
        for tick in range(100):
            load = ScalarReading(tick * TICK, share * CABLE.static_tension)
            envelope.step(Measurements(scalar={"load_cell": (load,)}), Asked(Mode.STANDBY, move), order)
        return bool(int(envelope.last.bits) & Bit.LOAD_IS_OFF)

    for _ in range(4):
        assert not read(1.0)
    assert read(1.5)
    assert not read(1.0)
    assert read(1.5)
    envelope.acknowledge()
    assert not read(1.5)
    assert read(1.0)


def ask(mean, request):
    kind, first, second = request
    if kind == "go":
        mean.move_to(mean.point.payout + first, second)
    elif kind == "drive":
        mean.drive(first, second)
    elif kind == "halt":
        mean.halt(first)
    elif kind == "stop":
        mean.stop()
    else:
        mean.jump_to(mean.point.payout)


@settings(max_examples=40)
@given(st.lists(st.tuples(REQUEST, st.integers(1, 400)), min_size=1, max_size=5))
def test_the_move_of_the_envelope_is_that_of_the_mean_payout_by_the_requests_alone(requests):
    """The mean payout's generator in Python is another formulation of the same move."""
    mean = MeanPayout(NOMINAL.move, tick_period=TICK)
    envelope = OrderEnvelope(NOMINAL, CABLE, TICK)
    order = WinchOrder(1, 0.0, 0.0, False)
    for request, ticks in requests:
        ask(mean, request)
        for _ in range(ticks):
            asked = Asked(Mode.MANUAL, mean.request)
            envelope.step(Measurements(), asked, order)
            assert envelope.last.move_rate == pytest.approx(mean.point.rate, abs=1e-9)
            mean.advance()


def test_a_distance_far_from_that_of_count_or_depth_sensor_is_not_taken():
    mean = MeanPayout(NOMINAL.move, tick_period=TICK)
    envelope = OrderEnvelope(NOMINAL, CABLE, TICK)
    order, still = WinchOrder(1, 0.0, 0.0, True), WinchReading(0.0, 2.0, 0.0, True)
    at_rest = Measurements(winch=still)
    envelope.step(at_rest, Asked(Mode.STANDBY, mean.request), order)
    mean.move_to(40.0, reference=5.0)  # an estimate takes a depth that is 5 m off for 40 m of wire
    envelope.step(at_rest, Asked(Mode.STANDBY, mean.request), order)
    assert envelope._core.state["move"]["distance"][0] == pytest.approx(5.0 + NOMINAL.envelope.move_tolerance)
    mean.move_to(3.0)  # a payout: the count says 2 m
    envelope.step(at_rest, Asked(Mode.STANDBY, mean.request), order)
    assert envelope._core.state["move"]["distance"][0] == pytest.approx(1.0 + NOMINAL.envelope.move_tolerance)


def test_every_margin_is_a_field_of_the_parameters_and_nothing_else_fills_the_design():
    design = nominal_design(NOMINAL, CABLE, TICK)["envelope"]
    changed = replace(NOMINAL, envelope=replace(NOMINAL.envelope, rate_factor=2.0, damping_rate=0.1))
    other = nominal_design(changed, CABLE, TICK)["envelope"]
    assert {name for name in design if design[name] != other[name]} == {"rate_factor", "damping_rate"}


def test_every_cause_has_its_alarm_and_every_alarm_of_the_envelope_is_high():
    causes, phases = [cause for cause in Cause if cause is not Cause.NOTHING], (Phase.HELD, Phase.CAUGHT)
    sent = [SimpleNamespace(cause=one, phase=phase, value=1.0, limit=0.5) for one in causes for phase in phases]
    assert {_alarm(one, "the law lqg").severity.word for one in sent} == {"high", "critical"}


@pytest.fixture(scope="module")
def loop():
    """Return a loop of B2 that compensates; its controller's orders become those of `wild`."""
    given = loop_parameters(load_scenario("b2_calm_300", settings=["all.duration=200", "all.seed=1"]))
    loop = ClosedLoop(given)
    while loop.tick < 50.0 / TICK:
        loop.step()
    return loop


def test_what_was_sent_is_what_estimate_adviser_and_the_next_stop_go_by_and_an_operator_releases_it(loop):
    controller, command = loop.controller, loop.controller._command
    assert controller.mode is Mode.COMPENSATING

    def be_wild(ordered):
        ordered["rate"] = math.nan

    begin = controller._begin
    change_order(controller, be_wild)
    outputs, _ = loop.step()
    assert [alarm.name for alarm in outputs.alarms] == ["ORDER_REPLACED: not finite"]
    assert f"for the author of the law {controller.parameters.law}" in outputs.alarms[0].text
    assert math.isfinite(outputs.order.payout_rate)
    assert controller.envelope.last.cause == Cause.NOT_FINITE
    assert "envelope" in command.last.governed.active
    sent = []
    for _ in range(round(45.0 / TICK)):
        outputs, _ = loop.step()
        given = controller._given
        if controller.envelope.last.phase in (Phase.TAKEN, Phase.RAMP):
            # set-points of the winch: the encoder has not jumped
            assert given.payout_rate == outputs.order.payout_rate
            assert command.last.governed.value == pytest.approx(outputs.order.payout_rate, abs=1e-9)
            sent.append(outputs.order.payout_rate)
    assert max(map(abs, sent)) > 0.05
    assert (controller.mode, outputs.order.brake) == (Mode.STOPPED, True)
    assert controller.envelope.last.phase == Phase.HELD

    controller._begin = begin
    controller.set_mode("compensating")
    seen = [loop.step()[0].mode for _ in range(round(40.0 / TICK))]
    assert seen[-1] == "compensating"
    assert controller.envelope.reason is None


LAW_OF_NAN = """
import math
from winch_controller_node.laws.law import ControlLaw, LawCommand

class Wild(ControlLaw):
    name = "wild"
    summary = "the rate of the boom tip; not a number while it is wild"
    required_sensors = ("mru",)
    feeds_back_unit = False
    is_wild = False

    def __init__(self, design, parameters):
        super().__init__(design, parameters)
        self.row = design.model.row("boom_tip_heave_rate")

    def command(self, state):
        return LawCommand(math.nan if Wild.is_wild else float(self.row @ state.x))
"""


def test_a_law_that_is_no_number_for_a_moment_leaves_none_in_any_order_and_compensates_again(tmp_path, monkeypatch):
    monkeypatch.setenv(registry.LOADED, "")
    monkeypatch.setattr(registry, "LAWS", dict(registry.LAWS))  # what is loaded does not stay
    (tmp_path / "wild.py").write_text(LAW_OF_NAN)
    law = f"winch_controller.law={tmp_path / 'wild.py'}:Wild"
    loop = ClosedLoop(loop_parameters(load_scenario("b2_calm_300", settings=["all.duration=200", "all.seed=1", law])))
    wild = type(loop.controller.design.make_law())
    while loop.tick < 50.0 / TICK:
        loop.step()
    assert loop.controller.mode is Mode.COMPENSATING
    wild.is_wild = True
    found = [loop.step()[0]]
    wild.is_wild = False
    assert [alarm.name for alarm in found[0].alarms] == ["ORDER_REPLACED: not finite"]
    found += [loop.step()[0] for _ in range(round(45.0 / TICK))]
    assert all(math.isfinite(one.order.payout + one.order.payout_rate) for one in found)
    assert loop.controller.mode is Mode.STOPPED
    loop.controller.set_mode("compensating")
    assert [loop.step()[0].mode for _ in range(round(40.0 / TICK))][-1] == "compensating"


def test_a_law_that_returns_no_command_is_named(loop, monkeypatch):
    command = loop.controller._command
    monkeypatch.setattr(command, "_law", SimpleNamespace(name="own", command=lambda state: None))
    with pytest.raises(TypeError, match=r"law own: command\(\) returned None; it must return a LawCommand"):
        command._asked_elsewhere(0)


class TestAlone:
    """The envelope of somebody else's controller."""

    def alone(self):
        return EnvelopeAlone(WinchEnvelopeParameters(), tick_period=TICK)

    def test_a_command_inside_the_bounds_passes_and_none_leaves_where_none_comes(self):
        alone = self.alone()
        order = WinchOrder(7, 0.0, 0.0, True)
        assert alone.step(Measurements(), order)[0] == order
        assert alone.step(Measurements(), None) == (None, [])

    def test_a_count_that_comes_late_is_as_old_as_its_stamp(self):
        behind = []
        for knows_time in (True, False):
            alone, most = self.alone(), 0.0
            for tick, time, way in late_counts():
                raw = Measurements(winch=WinchReading(time, way, 0.1, brake=False))
                alone.step(raw, WinchOrder(tick, 0.0, 0.1, False), tick * TICK if knows_time else math.nan)
                most = max(most, -alone.envelope.last.residual)
            behind.append(most)
        assert behind[0] < 0.007
        assert behind[1] > 0.015

    def test_a_wild_command_is_replaced_and_ends_in_the_brake_also_once_the_controller_is_silent(self):
        alone = self.alone()
        alone.step(Measurements(), WinchOrder(1, 0.0, 0.0, False))
        sent, codes = [], []
        for tick in range(2, 1000):
            command = WinchOrder(tick, 0.0, 50.0, False) if tick < 100 else None
            order, news = alone.step(Measurements(), command)
            sent.append(order)
            codes += [alarm.name for alarm in news]
        assert codes == ["ORDER_REPLACED: too fast"]
        assert sent[-1].brake
        assert np.all(np.diff([order.sequence for order in sent]) > 0)
        assert alone.acknowledge()

    def test_an_operators_speed_is_a_move_within_its_share_and_lapses(self):
        alone, rates = self.alone(), []
        for tick in range(400):
            if tick < 200:
                alone.ask_speed(9.0)
            alone.step(Measurements(), WinchOrder(tick + 1, 0.0, 0.0, False))
            rates.append(alone.envelope.last.move_rate)
        share = WinchEnvelopeParameters().operator.speed_share * WinchEnvelopeParameters().winch.speed_limit
        assert 0.1 < max(rates) <= share + 1e-9
        assert rates[-1] < 0.5 * max(rates)


def test_a_law_that_asks_for_twice_what_the_ship_explains_is_kept_within_it_and_nothing_is_taken_over(loop):
    """It was taken over within half a second, and the stop left the load swinging."""
    controller, command = loop.controller, loop.controller._command
    put(command._core_law.core.law, {"kind": LawKind.ANOTHER_LAW})
    begin, share = loop.tick, []
    bound = controller.envelope.last.rate_bound
    command._law = SimpleNamespace(
        command=lambda _: LawCommand(2.0 * bound * math.sin(0.5 * math.pi * (loop.tick - begin) * TICK))
    )
    for _ in range(round(4.0 / TICK)):
        loop.step()
        last = controller.envelope.last
        assert (last.phase, int(last.bits) & (Bit.AT_RATE | Bit.AT_TRAVEL)) == (Phase.FREE, 0)
        share.append(abs(last.speed) / last.rate_bound)
    assert max(share) == pytest.approx(0.9, abs=0.03)
