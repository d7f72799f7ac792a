"""The whole loop under any operator and any trouble: what never happens, whatever is asked for and whatever fails."""

import dataclasses

import numpy as np
import pytest
from cable_sim_node.node_parameters import CableSimNodeParameters, LinearModelParameters
from cable_sim_node.parameters import UnitParameters
from cable_sim_node.winch.parameters import WinchParameters
from heave_bringup.closed_loop import ClosedLoop, LoopParameters
from heave_node.interface.codes import WinchFault
from heave_node.parameters import build_parameters
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, rule, run_state_machine_as_test
from wave_vessel_node.parameters import WaveVesselParameters
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.supervision.modes import REQUESTS, SETTLING_LIMIT, STOPPING_LIMIT, ModeError

DT = 0.05
INERTIA, DAMPING = 7.339769, 0.1906759
"""The 900 m system of thesis 6.2.6 as identified there."""

FADE_TIME = 2.0
STILL = 0.02
"""No change of mode moves the unit by more than this in calm water [m]."""


def loop_in(height, seed):
    """Return the loop on the two-state plant in a sea of significant wave `height` [m]."""
    belief = {
        "length": 900.0,
        "cable_model.inertia": INERTIA,
        "cable_model.damping": DAMPING,
        "sea.significant_wave_height": max(height, 0.1),
        "sea.peak_period": 10.0,
        "modes.settling_time": 3.0,
        "modes.fade_in_time": FADE_TIME,
        "modes.fade_out_time": FADE_TIME,
    }
    waves = {"significant_wave_height": height, "peak_period": 10.0, "ramp": 5.0}
    linear = LinearModelParameters(INERTIA, DAMPING)
    return ClosedLoop(
        LoopParameters(
            sea=build_parameters(WaveVesselParameters, waves, where="test"),
            plant=CableSimNodeParameters(model="linear", linear=linear, length=900.0, unit=UnitParameters()),
            winch=WinchParameters(),
            controller=build_parameters(WinchControllerParameters, belief, where="test"),
            seed=seed,
        )
    )


class AnyOperatorAnyTrouble(RuleBasedStateMachine):
    """Requests, an operator's speed, a gap of each sensor and faults of the winch, in any order."""

    @initialize(height=st.sampled_from([0.01, 1.5, 3.0]), seed=st.integers(1, 1000))
    def begin(self, height, seed):
        self.loop = loop_in(height, seed)
        self.is_calm = height < 0.1
        self.is_moved = False
        self.gap, self.fault, self.trouble_left = (), WinchFault.NONE, 0
        step = self.loop.controller.step
        self.loop.controller.step = lambda tick, measured: step(tick, self.troubled(measured))
        self.start = None
        self.last_rate = 0.0

    def troubled(self, measured):
        """Return the measurements with what fails now left out."""
        if self.trouble_left <= 0:
            return measured
        self.trouble_left -= 1
        scalar = {name: readings for name, readings in measured.scalar.items() if name not in self.gap}
        kept = dataclasses.replace(measured, mru=() if "mru" in self.gap else measured.mru, scalar=scalar)
        winch = measured.winch
        return kept if winch is None else dataclasses.replace(kept, winch=winch._replace(fault=self.fault))

    @rule(mode=st.sampled_from([mode.value for mode in REQUESTS]))
    def ask(self, mode):
        try:
            self.loop.controller.set_mode(mode)
        except ModeError as error:
            assert str(error)

    @rule(speed=st.floats(-1.0, 1.0))
    def operate(self, speed):
        if self.is_calm:
            return
        try:
            self.loop.controller.operate(speed)
        except ModeError as error:
            assert str(error)

    @rule(
        gap=st.sampled_from([("mru",), ("depth",), ("load_cell",), ("mru", "depth")]),
        fault=st.sampled_from([WinchFault.NONE, WinchFault.NONE, WinchFault.DRIVE, WinchFault.EMERGENCY_STOP]),
        ticks=st.integers(1, 100),
    )
    def trouble(self, gap, fault, ticks):
        self.gap, self.fault, self.trouble_left = gap, fault, ticks

    @rule(ticks=st.integers(1, 80))
    def wait(self, ticks):
        for _ in range(ticks):
            self.tick()

    @rule()
    def a_stop_ends_under_the_brake(self):
        self.loop.controller.set_mode("stopped")
        for _ in range(round((FADE_TIME + SETTLING_LIMIT + STOPPING_LIMIT + 1.0) / DT)):
            outputs = self.tick()
            if outputs.order.brake:
                break
        assert outputs.report.mode in ("stopped", "emergency_stop")

    def tick(self):
        outputs, row = self.loop.step()
        order, winch = outputs.order, self.loop.winch.state
        assert np.isfinite([order.payout, order.payout_rate]).all()
        assert np.isfinite(outputs.report.estimate).all()
        assert not order.brake or order.payout_rate == 0.0
        assert abs(order.payout_rate) <= 2.0 + 1e-9
        assert abs(winch.payout_rate) <= 2.0 + 1e-9
        assert abs(winch.payout_rate - self.last_rate) <= 1.5 * DT + 1e-9
        self.last_rate = winch.payout_rate
        self.start = row[2] if self.start is None else self.start
        if self.is_calm:
            assert abs(row[2] - self.start) < STILL
        return outputs


def run_machine(examples, steps):
    run_state_machine_as_test(
        AnyOperatorAnyTrouble,
        settings=settings(max_examples=examples, stateful_step_count=steps, deadline=None, derandomize=True),
    )


def test_no_operator_and_no_trouble_takes_the_loop_beyond_its_limits():
    run_machine(2, 15)


@pytest.mark.long
def test_nor_do_ten_thousand_steps():
    run_machine(200, 50)
