"""A pass over a record against the loop's own filter, and its linearity in the readings."""

import dataclasses

import numpy as np
import pytest
from heave_core.filter import no_slack
from winch_controller_node.adviser.filter_pass import PassInput, PassModel, run_pass
from winch_controller_node.design.design import design_controller
from winch_controller_node.model.estimator import KalmanEstimator, Measurement
from winch_controller_node.node_parameters import WinchControllerParameters

DT = 0.05
TICKS = 400
NO_GATE = 1e12


@pytest.fixture(scope="module")
def design():
    return design_controller(WinchControllerParameters(length=900.0), tick_period=DT)


def model_of(design, *, with_drag=False, with_slack=False):
    """Return the model of a pass; drag and slack are those of the design where they are asked for."""
    model, known = design.model, design.measurements
    rows = np.array([one.row for one in known])
    change = rows @ model.A - rows
    return PassModel(
        F=model.A,
        B=model.B[:, 0],
        Q=model.noise_covariance,
        start=design.initial_covariance,
        rows=np.array([rows, change, change @ model.A - change]),
        drag=design.drag if with_drag else design.drag._replace(quadratic=0.0),
        slack=design.slack if with_slack else no_slack(model.order, len(known)),
        state_names=model.state_names,
    )


def record_of(design, *, size=1.0, each_tick=1, seed=1):
    """Return commands, and readings as (tick, measurement, offset, value): `each_tick` of them, in turn.

    Readings are of no motion at all, `size` large: a filter has to follow whatever it reads.
    """
    random = np.random.default_rng(seed)
    commands = 0.3 * np.sin(0.7 * DT * np.arange(TICKS)) + 0.05 * random.standard_normal(TICKS)
    count = len(design.measurements)
    readings = []
    for tick in range(TICKS):
        for i in range(each_tick):
            which = (tick * each_tick + i) % count
            value = size * np.sin(0.6 * DT * tick + which) + 0.02 * random.standard_normal()
            readings.append((tick, which, random.uniform(-0.5, 0.5), value))
    return commands, readings


def input_of(design, commands, readings, *, speed=0.0, missing=0.0, values=None):
    """Return a record in columns; `values` are those of the readings, shape (m, c), in place of the record's own."""
    ticks, which, offsets, read = (np.array(column) for column in zip(*readings, strict=True))
    columns = read[:, None] if values is None else values
    moved = np.zeros((TICKS, columns.shape[1]))
    moved[:, 0] = commands
    return PassInput(
        commands=moved,
        ends=np.searchsorted(ticks, np.arange(TICKS), side="right").astype(np.int64),
        which=which.astype(np.int64),
        offsets=offsets,
        variances=np.array([design.measurements[one].sigma for one in which]) ** 2,
        values=np.ascontiguousarray(columns),
        unit_speed=np.broadcast_to(speed, TICKS).astype(float),
        missing_push=np.broadcast_to(missing, TICKS).astype(float),
    )


def followed(design, model, commands, readings):
    """Return what the loop's filter makes of a record: innovations over sigma, variances, and speed and missing push.

    Those are of the state before each tick, by which its step goes. It takes in all that it reads.
    """
    estimator = KalmanEstimator(
        design.model, design.measurements, model.start, gate=NO_GATE, drag=model.drag, slack=model.slack
    )
    names = [known.name for known in design.measurements]
    estimator.step(-1, 0.0, [])
    speed, missing, said = [], [], []
    for tick in range(TICKS):
        x = estimator.estimate
        speed.append(abs(x[model.drag.rate]))
        missing.append(estimator.missing_push)
        mine = [Measurement(names[w], v, t, offset=o) for t, w, o, v in readings if t == tick]
        estimator.step(tick, commands[tick], mine)
        said += [estimator.innovations[one.name] for one in mine]
    innovations = np.array([one.value / one.sigma for one in said])
    return estimator, innovations, np.array([one.sigma**2 for one in said]), np.array(speed), np.array(missing)


def rounding(design, estimator):
    """Return by how much innovations over sigma of two filters of the same equations may differ.

    The last place of the largest state, up to 55 here, over the smallest sigma, 0.3 mm, is 2e-11; each tick rounds a
    sum of as many products as there are states, at random: ten standard deviations of that walk are 2e-8.
    """
    largest, least = np.max(np.abs(estimator.estimate)), min(known.sigma for known in design.measurements)
    return 10.0 * np.sqrt(TICKS * design.model.order) * np.spacing(largest) / least


@pytest.mark.parametrize(
    ("with_drag", "with_slack", "size"),
    [(False, False, 1.0), (True, False, 3.0), (False, True, 8.0), (True, True, 8.0)],
    ids=["linear", "drag", "slack", "both"],
)
def test_a_pass_says_of_each_reading_what_the_filter_of_the_loop_says(design, with_drag, with_slack, size):
    """The compiled filter has a twin by a library of its own; one reading a tick: neither knows of another before."""
    model = model_of(design, with_drag=with_drag, with_slack=with_slack)
    commands, readings = record_of(design, size=size)
    estimator, innovations, variances, speed, missing = followed(design, model, commands, readings)
    # the record is one in which what is asked for acts
    assert not with_drag or np.count_nonzero(model.drag.quadratic * speed > model.drag.damping) > 100
    assert not with_slack or np.count_nonzero(missing) > 20
    used = np.ones(len(design.measurements), dtype=np.bool_)
    result = run_pass(model, input_of(design, commands, readings, speed=speed, missing=missing), used)
    np.testing.assert_allclose(result.innovations[:, 0], innovations, atol=rounding(design, estimator), rtol=1e-9)
    np.testing.assert_allclose(result.variances, variances, rtol=1e-9)
    np.testing.assert_allclose(result.state[:, 0], estimator.estimate, atol=1e-9)
    np.testing.assert_allclose(result.covariance, estimator.covariance, atol=1e-9)


def test_a_model_of_a_pass_has_the_start_it_was_given(design):
    """Without a reading the covariance is that of the start, propagated by the model."""
    model = model_of(design)
    commands, readings = record_of(design)
    none = np.zeros(len(design.measurements), dtype=np.bool_)
    result = run_pass(model, input_of(design, commands, readings), none)
    P = model.start
    for _ in range(TICKS):
        P = model.F @ P @ model.F.T + model.Q
    np.testing.assert_allclose(result.covariance, P, rtol=1e-9, atol=1e-12)
    assert dataclasses.is_dataclass(result)
