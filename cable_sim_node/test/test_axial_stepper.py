"""The axial cable tick by tick: the same motion as over a whole record, and errors in one line."""

import numpy as np
import pytest
from cable_sim_node.parameters import CableSimParameters
from cable_sim_node.vertical.axial import simulate_axial
from cable_sim_node.vertical.axial_line import axial_line
from cable_sim_node.vertical.axial_stepper import AxialError, AxialInput, AxialStepper

TICK = 0.05
PARAMETERS = CableSimParameters()
LINE = axial_line(PARAMETERS)


def moved(boom_tip, payout, segments, substeps):
    """Return the unit's heave at each tick under a boom tip and a payout, sampled at the ticks."""
    rates = np.gradient(boom_tip, TICK), np.gradient(payout, TICK)
    rows = np.column_stack([boom_tip, rates[0], payout, rates[1]]).tolist()
    stepper = AxialStepper(
        LINE, PARAMETERS.length, AxialInput(*rows[0]), segments=segments, duration=TICK, substeps=substeps
    )
    return np.array([stepper.state.unit_heave, *(stepper.advance(AxialInput(*row)).unit_heave for row in rows[1:])])


def test_ticks_give_the_motion_of_a_whole_record_and_converge_to_it():
    time = np.arange(0.0, 30.0, TICK)
    ramp = np.minimum(time / 15.0, 1.0) ** 2
    boom_tip, payout = 0.8 * ramp * np.sin(time), 0.3 * ramp * np.sin(0.7 * time)
    whole = simulate_axial(
        LINE, PARAMETERS.length, boom_tip, TICK, payout=payout, segments=40, largest_step=0.005
    ).unit_heave
    coarse, fine = moved(boom_tip, payout, 12, 4), moved(boom_tip, payout, 40, 10)
    assert np.abs(fine - whole).max() < 2e-5  # the ends of a cubic spline against differences of its samples
    assert np.abs(coarse - whole).max() < 2e-3  # BDF2 at 12.5 ms and the mesh: 0.2 % of a motion of a metre


def test_many_ticks_at_once_are_those_one_by_one_to_the_last_bit():
    time = np.arange(0.0, 20.0, TICK)
    rows = np.column_stack([0.8 * np.sin(time), 0.8 * np.cos(time), 0.3 * np.cos(time), -0.3 * np.sin(time)])
    one, many = (
        AxialStepper(LINE, PARAMETERS.length, AxialInput(*rows[0]), segments=12, duration=TICK, substeps=4)
        for _ in range(2)
    )
    expected = np.array([one.advance(AxialInput(*row)) for row in rows[1:]])
    assert np.array_equal(np.vstack([many.follow(rows[1:200]), many.follow(rows[200:])]), expected)
    assert many.state == one.state


def test_a_cable_that_is_hauled_in_to_nothing_is_refused():
    with pytest.raises(AxialError, match=r"cannot have a length of -1 m"):
        AxialStepper(
            LINE,
            PARAMETERS.length,
            AxialInput(0.0, 0.0, -1.0 - PARAMETERS.length, 0.0),
            segments=4,
            duration=TICK,
            substeps=1,
        )
