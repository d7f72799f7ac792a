"""What must hold before the winch follows the sea."""

from types import SimpleNamespace

import pytest
from winch_controller_node.estimation.loop_tick import Motion
from winch_controller_node.laws.parts.winch_limits import WinchLimits
from winch_controller_node.model.estimator import Innovation
from winch_controller_node.parameters.laws import EntryParameters
from winch_controller_node.supervision.entry_gates import EntryGates

DT = 0.05
LIMITS = WinchLimits(2.0, 1.5, -50.0, 50.0)


def observe(gates, nis, readings):
    """Let the gates see readings of the depth sensor in every fourth tick."""
    for number in range(4 * readings):
        innovations = {"unit_heave": Innovation(nis**0.5, 1.0, nis, True)} if number % 4 == 0 else {}
        gates.observe(SimpleNamespace(boom_tip=Motion(0.0, 0.0), sensed=SimpleNamespace(innovations=innovations)))


def test_readings_far_off_close_the_gate_for_as_long_as_it_says():
    """Mean squares of 30 fall to 16 with a memory of 50 readings, 0.2 s apart: 50 ln(29/15) 0.2 s."""
    gates = EntryGates(EntryParameters(innovation=4.0), window=60.0, tick_period=DT)
    observe(gates, 30.0, 600)
    words = gates.for_compensation(0.0, LIMITS, 0.1, 2.0)
    assert "innovations of unit_heave are 5.5 standard deviations; at most 4 is allowed: about 7 s" in words
    waited = 0
    while gates.for_compensation(0.0, LIMITS, 0.1, 2.0):
        observe(gates, 1.0, 1)
        waited += 1
    assert waited * 4 * DT == pytest.approx(6.6, abs=0.3)
