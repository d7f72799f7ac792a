import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from winch_controller_node.design.design import design_controller
from winch_controller_node.motion.mean_motion import MeanMotion
from winch_controller_node.motion.programme import Programme
from winch_controller_node.motion.trajectory import MeanPayout
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.laws import MoveParameters, ProgrammeParameters

DT = 0.05


def points(mean, ticks):
    return [mean.advance() for _ in range(ticks)]


@settings(max_examples=30, deadline=None)
@given(st.lists(st.tuples(st.floats(-60.0, 60.0), st.integers(1, 1500)), min_size=1, max_size=4))
def test_moves_stay_within_speed_and_acceleration_whatever_is_asked_for(moves):
    parameters = MoveParameters(speed=0.5, acceleration=0.05)
    mean = MeanPayout(parameters, tick_period=DT)
    for target, ticks in moves:
        mean.move_to(target)
        before = mean.point
        for point in points(mean, ticks):
            assert abs(point.rate) <= 0.5 + 1e-9
            assert abs(point.rate - before.rate) <= 0.05 * DT + 1e-9 or point.rate == 0.0
            assert abs(point.payout - before.payout) <= 0.5 * DT + 1e-9
            before = point


@given(st.floats(-40.0, 40.0))
@settings(max_examples=20, deadline=None)
def test_a_move_arrives_without_overshoot(target):
    mean = MeanPayout(MoveParameters(), tick_period=DT)
    mean.move_to(target)
    path = points(mean, 4000)
    assert not mean.is_moving
    assert path[-1].payout == pytest.approx(target, abs=0.006)
    assert max(abs(point.payout) for point in path) <= abs(target) + 0.006


def test_a_cancelled_move_stops_within_the_braking_distance_and_stays():
    """From 0.5 m/s at 0.05 m/s^2 the braking distance is 2.5 m; building up the acceleration adds 1 s of way."""
    mean = MeanPayout(MoveParameters(speed=0.5, acceleration=0.05), tick_period=DT)
    mean.move_to(40.0)
    points(mean, 600)
    at = mean.point.payout
    mean.stop()
    points(mean, 1000)
    assert mean.point.rate == 0.0
    assert 0.0 < mean.point.payout - at < 2.5 + 0.5 * 2.0
    assert not mean.is_moving


@settings(max_examples=60, deadline=None)
@given(
    target=st.floats(-60.0, 60.0),
    speed=st.floats(0.1, 2.0),
    acceleration=st.floats(0.03, 0.5),
    jerk_time=st.floats(0.0, 2.0),
)
def test_the_time_to_go_is_what_the_move_takes_and_falls_to_zero_on_arrival(target, speed, acceleration, jerk_time):
    mean = MeanPayout(MoveParameters(speed=speed, acceleration=acceleration, jerk_time=jerk_time), tick_period=DT)
    mean.move_to(target)
    told = [mean.time_to_go]
    while mean.is_moving:
        mean.advance()
        told.append(mean.time_to_go)
    assert told[-1] == 0.0
    taken = DT * np.arange(len(told) - 1, -1, -1)
    assert np.abs(np.array(told) - taken).max() <= 3.0 * DT + 0.02 * jerk_time


def test_a_stop_and_a_driven_motion_have_no_time_to_go():
    mean = MeanPayout(MoveParameters(), tick_period=DT)
    mean.move_to(40.0)
    points(mean, 200)
    mean.stop()
    assert mean.time_to_go == 0.0
    mean.drive(0.2, 0.05)
    assert mean.time_to_go == 0.0


def test_a_move_to_nowhere_is_refused():
    with pytest.raises(ValueError, match="finite payout"):
        MeanPayout(MoveParameters(), tick_period=DT).move_to(float("nan"))


def test_the_programme_hands_out_each_step_once_in_order():
    programme = Programme(
        ProgrammeParameters(
            move_times=(10.0, 30.0), move_payouts=(5.0, 0.0), mode_times=(20.0,), modes=("constant_tension",)
        )
    )
    assert programme.due(9.9) == []
    assert [step.payout for step in programme.due(10.0)] == [5.0]
    assert [step.mode for step in programme.due(31.0)] == ["constant_tension", ""]
    assert programme.due(1000.0) == []


def test_a_programme_that_contradicts_itself_is_refused_in_words():
    with pytest.raises(ValueError, match="as many values as programme"):
        ProgrammeParameters(move_times=(1.0,))
    with pytest.raises(ValueError, match="must be ascending"):
        ProgrammeParameters(mode_times=(2.0, 1.0), modes=("standby", "standby"))


def test_a_halt_takes_its_deceleration_and_no_longer():
    """From v at a: v/a of time and v^2/(2 a) of way."""
    mean = MeanPayout(MoveParameters(), tick_period=0.05)
    mean.move_to(100.0, 0.5)
    while mean.point.rate < 0.499:
        mean.advance()
    start = mean.point
    mean.halt(0.5)
    points = [mean.advance() for _ in range(30)]
    ticks = sum(point.rate > 0.0 for point in points)
    assert ticks * 0.05 == pytest.approx(start.rate / 0.5, abs=0.05)
    assert points[-1].payout - start.payout == pytest.approx(start.rate**2 / (2.0 * 0.5), abs=0.5 * 0.05)
    assert not mean.is_moving


def test_drum_and_unit_that_begin_elsewhere_stay_there():
    """At rest the state is x = A x + B u under the command of a mean payout that rests; of a servo that is no speed."""
    design = design_controller(WinchControllerParameters(), tick_period=DT)
    winch, motion = design.parameters.winch, MeanMotion(MoveParameters(), design.model.order, tick_period=DT)
    motion.begin_at(-7.0, design.model, winch)
    for _ in range(3):
        motion.advance(design.model, motion.reference_command(winch), is_braked=False)
        assert (motion.set_point, motion.mean.is_moving) == (-7.0, False)
        assert motion.state[design.model.state("payout")] == pytest.approx(-7.0)
        assert motion.state[design.model.state("unit_heave")] == pytest.approx(7.0)
    with pytest.raises(ValueError, match="read-only"):
        motion.state[0] = 1.0
