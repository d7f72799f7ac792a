"""The table of modes: what holds of every row, and of every run through it."""

from pathlib import Path

import pytest
from heave_node.interface.codes import WinchFault
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule
from winch_controller_node.core.supervision.mode_picture import page
from winch_controller_node.core.supervision.modes import (
    BRAKED,
    MOVING,
    REQUESTS,
    SETTLING_LIMIT,
    STOPPING_LIMIT,
    TABLE,
    Event,
    Mode,
    ModeError,
)
from winch_controller_node.parameters.laws import ModeParameters

from tests.supervised import Machine, Told

DT = 0.05


def rows(event):
    return [row for row in TABLE if row.event is event]


def test_every_mode_is_braked_or_may_move():
    assert set(BRAKED) | set(MOVING) == set(Mode)
    assert not set(BRAKED) & set(MOVING)


@pytest.mark.parametrize("event", [Event.ASK_STOPPED, Event.ASK_EMERGENCY_STOP])
def test_a_stop_is_taken_in_every_mode_without_a_condition(event):
    assert {mode for row in rows(event) if not row.guards for mode in row.sources} == set(Mode)


def test_a_fault_of_the_winch_brakes_whatever_moves_without_a_condition():
    for event in (Event.WINCH_FAULT, Event.WINCH_EMERGENCY_STOP):
        taken = {mode for row in rows(event) if not row.guards for mode in row.sources}
        assert set(MOVING) <= taken
        assert all(row.target in BRAKED for row in rows(event))


def test_law_off_is_never_left():
    assert all(row.target is Mode.OFF for row in TABLE if Mode.OFF in row.sources)


def test_only_an_operator_leaves_an_emergency_stop():
    assert {row.event for row in TABLE if Mode.EMERGENCY_STOP in row.sources} <= set(REQUESTS.values())


def test_no_row_is_hidden_behind_one_above_it():
    seen = set()
    for row in TABLE:
        for mode in row.sources:
            assert (mode, row.event) not in seen, f"{mode.value}, {row.event.value}"
            if not row.guards:
                seen.add((mode, row.event))


def test_the_page_of_the_documentation_is_the_table():
    """If this fails: python -m winch_controller_node.core.supervision.mode_picture > docs/modes.md."""
    assert (Path(__file__).parents[2] / "docs" / "modes.md").read_text(encoding="utf-8") == page()


WELL = Told(lost="", has_estimate=True, winch_fault=WinchFault.NONE, harm="", speed=0.0)
PARAMETERS = ModeParameters(settling_time=1.0, fade_in_time=2.0, fade_out_time=2.0, coast_time=0.5, resume_time=3.0)


class AnyOperatorAnyTrouble(RuleBasedStateMachine):
    """Requests, landings and every trouble in any order and for any time."""

    @initialize(moves_winch=st.booleans())
    def begin(self, moves_winch):
        self.modes = Machine(PARAMETERS, moves_winch=moves_winch, factor=1.0, tick_period=DT)
        self.situation = WELL
        self.may_move = moves_winch
        self.authority_before = 0.0

    @rule(mode=st.sampled_from([mode.value for mode in REQUESTS]))
    def ask(self, mode):
        before = self.modes.mode
        try:
            self.modes.request(mode)
        except ModeError as error:
            assert str(error)
            assert mode not in ("stopped", "emergency_stop")
            assert self.modes.mode is before

    @rule()
    def touch_down(self):
        self.modes.touch_down()

    @rule()
    def lift_off(self):
        self.modes.lift_off()

    @rule(
        lost=st.sampled_from(["", "", "mru frozen", "encoder stale"]),
        fault=st.sampled_from([0, 0, 0, WinchFault.DRIVE, WinchFault.EMERGENCY_STOP, 99]),
        harm=st.sampled_from(["", "", "compensation is harmful"]),
        gate=st.sampled_from(["", "", "peaks of 2.0 m/s^2"]),
        tension=st.sampled_from(["", "the unit is suspended"]),
        settled=st.booleans(),
        speed=st.sampled_from([0.0, 1.0]),
    )
    def trouble(self, lost, fault, harm, gate, tension, settled, speed):
        self.situation = Told(
            lost=lost,
            has_estimate=True,
            winch_fault=fault,
            harm=harm,
            speed=speed,
            is_settled=settled,
            gates=lambda: gate,
            tension=lambda: tension,
        )

    @rule(ticks=st.integers(1, 120))
    def wait(self, ticks):
        for _ in range(ticks):
            self.tick()

    def tick(self):
        before, authority = self.modes.mode, self.modes.authority
        output = self.modes.step(self.situation)
        assert output.brake == (output.mode in BRAKED)
        assert not (output.brake and output.authority)
        assert self.may_move or output.mode is Mode.OFF
        if output.mode is before and output.mode in (Mode.COMPENSATING, Mode.FADE_OUT):
            # authority has its ramps of 2 s
            assert abs(output.authority - authority) <= DT / 2.0 + 1e-12
        if before is Mode.EMERGENCY_STOP:
            assert output.mode is before
        assert output.reason or output.mode is Mode.COMPENSATING

    @rule()
    def a_stop_ends_under_the_brake_whatever_else_happens(self):
        self.modes.request("stopped")
        for _ in range(round((PARAMETERS.fade_out_time + SETTLING_LIMIT + STOPPING_LIMIT + 1.0) / DT)):
            self.tick()
        assert self.modes.mode in (Mode.OFF, Mode.STOPPED, Mode.EMERGENCY_STOP)

    @rule()
    def nothing_compensates_again_after_a_stop_before_somebody_asks(self):
        self.modes.request("stopped")
        self.situation = WELL
        for _ in range(800):
            self.tick()
            assert self.modes.mode not in (Mode.COMPENSATING, Mode.CONSTANT_TENSION, Mode.MANUAL)

    @invariant()
    def authority_is_a_share(self):
        if hasattr(self, "modes"):
            assert 0.0 <= self.modes.authority <= 1.0


TestAnyOperatorAnyTrouble = AnyOperatorAnyTrouble.TestCase
TestAnyOperatorAnyTrouble.settings = settings(max_examples=25, stateful_step_count=30, deadline=None)
