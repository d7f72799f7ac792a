"""The compiled Kalman filter beside one on filterpy's."""

import math
from collections import deque
from dataclasses import dataclass, field
from unittest import mock

import filterpy.kalman
import numpy as np
import pytest
from heave_core.filter import UNCERTAINTY, UNCERTAINTY_TIME, Drag, FilterModel, Gate, KalmanFilter, Slack
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import linear_model
from hypothesis import given, settings
from hypothesis import strategies as st
from winch_controller_node.design.prediction import corrected_covariance, filter_gain
from winch_controller_node.model import estimator as estimator_module
from winch_controller_node.model.estimator import KalmanEstimator, Measurement, MeasurementModel, RecordedTick

TICK, WHICH, VALUE, OFFSET, VARIANCE, WEIGHTS = range(6)
"""Columns of a reading; from the last on pairs of a state and its further weight."""

STATES = ("heave", "rate", "scale", "lever", "bias")
SENSORS = ("heave", "scaled", "rate", "ungated")


@dataclass
class _Tick:
    """What the reference keeps of one tick: the prediction for it, the readings used, the command that followed."""

    x: Array
    P: Array
    used: list[Array] = field(default_factory=list)
    command: float = 0.0


class ReferenceKalmanFilter:
    """The classic filter of thesis 6.3.4 as filterpy has it: readings one after the other, no shortcut.

    It takes many times as long as the compiled one, and gives the same estimate within rounding.

    Parameters
    ----------
    model, gate, kept, x, P : as for `KalmanFilter`
    """

    def __init__(self, model: FilterModel, gate: Gate, kept: int, x: Array, P: Array) -> None:
        self._model, self._gate, self._noise = model, gate, model.Q
        self._filter = filterpy.kalman.KalmanFilter(dim_x=len(x), dim_z=1, dim_u=1)
        self._set_state(x, P)
        self._past: deque[_Tick] = deque(maxlen=kept)
        self._newest: int | None = None
        self.streams = np.full(len(model.rows), math.nan)
        self.refusals = np.zeros(len(model.rows), dtype=np.int64)

    @property
    def x(self) -> Array:
        """Estimate, shape (n,)."""
        return np.asarray(self._filter.x[:, 0])

    @property
    def P(self) -> Array:
        """Covariance of the estimate, shape (n, n)."""
        return np.asarray(self._filter.P)

    @property
    def tick(self) -> int | None:
        """Newest tick; None before the first."""
        return self._newest

    def _set_state(self, x: Array, P: Array) -> None:
        self._filter.x, self._filter.P = np.array(x, dtype=float)[:, None], np.array(P, dtype=float)

    def set_noise(self, covariance: Array) -> None:
        """Use another covariance of the process noise."""
        self._noise = covariance

    @property
    def missing_push(self) -> float:
        """How much further down the model pushes the unit than a slack cable does."""
        slack = self._model.slack
        return max(float(-slack.pull @ self.x) - slack.largest, 0.0)

    def run(self, ticks: list[tuple[float, ...]], readings: list[tuple[float, ...]]) -> list[list[float]]:
        """Go through a run of ticks; return the result of each reading."""
        said: list[tuple[float, float, float, bool]] = []
        table = np.array(readings, dtype=float).reshape(len(readings), WEIGHTS + 4)
        for tick, command, end in ticks:
            self._advance(int(tick), command)
            delivered = table[len(said) : int(end)]
            for measured in sorted(set(delivered[:, TICK])) if len(delivered) else ():
                said += self._take(int(measured), delivered[delivered[:, TICK] == measured])
        return np.array(said, dtype=float).reshape(-1, 4).tolist()

    def _stepped(self) -> tuple[Array, Array, Array]:
        """Return F, B and Q of a step under the drag and the slack of the present state.

        Drag D F D and D Q D with D = diag(1, .., sqrt(exp(-c h/a)), .., 1), and a spring that gives way to the weight.
        """
        drag, slack, x = self._model.drag, self._model.slack, self.x
        excess = max(drag.quadratic * abs(x[drag.rate]) - drag.damping, 0.0) / drag.inertia
        D = np.eye(len(x))
        D[drag.rate, drag.rate] = math.sqrt(math.exp(-excess * drag.tick_period))
        F, B, Q = D @ self._model.F @ D, D @ self._model.B, D @ self._noise @ D
        missing, unit = self.missing_push, np.eye(len(x))[slack.rate]
        if missing > 0.0:
            F -= missing / (missing + slack.largest) * slack.tick_period / slack.inertia * np.outer(unit, slack.pull)
        errors = (excess * abs(x[drag.rate]), missing / slack.inertia)
        for state, error, period in zip(
            (drag.rate, slack.rate), errors, (drag.tick_period, slack.tick_period), strict=True
        ):
            Q[state, state] += (UNCERTAINTY * error) ** 2 * UNCERTAINTY_TIME * period
        return F, B, Q

    def _advance(self, tick: int, command: float) -> None:
        """Predict for a `tick`, with all between, under the drag of the speed before it."""
        self._filter.F, B, self._filter.Q = self._stepped()
        self._filter.B = B[:, None]
        if self._newest is None:
            self._past.append(_Tick(self.x, self.P))
        else:
            for _ in range(self._newest, tick):
                self._past[-1].command = command
                self._predict(command)
                self._past.append(_Tick(self.x, self.P))
        self._newest = tick

    def _predict(self, command: float) -> None:
        self._filter.predict(u=np.array([[command]]))

    def _take(self, tick: int, readings: Array) -> list[tuple[float, float, float, bool]]:
        """Take in the `readings` measured at a `tick`, and run forward again to the present; return what they said."""
        index = len(self._past) - 1 - ((self._newest or 0) - tick)
        if index < 0:
            return [(math.nan, math.nan, math.nan, False)] * len(readings)
        entry = self._past[index]
        if index < len(self._past) - 1:
            self._set_state(entry.x, entry.P)
            self._update(entry.used)
        for reading in readings:
            reading[VARIANCE] += (self._model.slack.reads[int(reading[WHICH])] * self.missing_push) ** 2
        judged = [self._judge(reading) for reading in readings]
        accepted = [reading for reading, (_, is_used) in zip(readings, judged, strict=True) if is_used]
        self._update(accepted)
        entry.used += accepted
        for before, after in zip(list(self._past)[index:], list(self._past)[index + 1 :], strict=False):
            self._predict(before.command)
            after.x, after.P = self.x, self.P
            self._update(after.used)
        return [said for said, _ in judged]

    def _judge(self, reading: Array) -> tuple[tuple[float, float, float, bool], bool]:
        """Compare a reading with its prediction; return what it says, and whether it is used."""
        gate, which = self._gate, int(reading[WHICH])
        row, predicted = self._linearised(reading)
        variance = float(row @ self.P @ row + reading[VARIANCE])
        innovation = float(reading[VALUE]) - predicted
        nis = innovation * innovation / variance  # a power would raise OverflowError for a number that is absurd
        # a stream that goes on where its last reading was says something of the model, not of the sensor
        step = innovation - float(self.streams[which])
        is_stream = step * step <= max(2.0 * gate.threshold * variance, 0.25 * innovation * innovation)
        accepted = nis <= gate.threshold or ((is_stream or not self._model.is_gated[which]) and math.isfinite(nis))
        self.refusals[which] = 0 if accepted else self.refusals[which] + 1
        # that many in a row: it is the filter that is wrong, and its covariance must be large enough to come back
        is_lost = bool(self.refusals[which] > gate.limit) and math.isfinite(nis)
        if is_lost:
            self._set_state(self.x, self.P + gate.added)
            self.refusals[which] = 0
        if accepted or is_lost:
            self.streams[which] = innovation
        return (innovation, math.sqrt(variance), nis, accepted), accepted or is_lost

    def _linearised(self, reading: Array) -> tuple[Array, float]:
        """Return the row of a reading at the present estimate, and its prediction."""
        model, which, offset = self._model, int(reading[WHICH]), float(reading[OFFSET])
        row = model.rows[which] + offset * model.changes[which] + 0.5 * offset * (offset - 1.0) * model.bends[which]
        for state, weight in reading[WEIGHTS:].reshape(-1, 2):
            row = row + (weight * np.eye(len(row))[int(state)] if state >= 0.0 else 0.0)
        plain, scale_state = float(row @ self.x), model.scale_states[which]
        if scale_state < 0:
            return row, plain
        scale = 1.0 + float(self.x[scale_state])
        row = scale * row
        row[scale_state] += plain
        return row, scale * plain

    def _update(self, readings: list[Array]) -> None:
        """Take in readings one by one, all linearised at the present estimate: their noise is independent."""
        x = self.x
        for reading, (row, predicted) in zip(readings, [self._linearised(one) for one in readings], strict=True):
            # the filter predicts H x; a bilinear measurement predicts something else
            value = reading[VALUE] - predicted + row @ x
            self._filter.update(value, R=reading[VARIANCE], H=row[None, :])


def estimator(seed, *, linear, is_peer=False):
    """Return an estimator of a random stable model, whose memory is short and which gives a sensor up soon."""
    random = np.random.default_rng(seed)
    A = random.standard_normal((5, 5))
    A *= 0.95 / np.max(np.abs(np.linalg.eigvals(A)))
    model = linear_model(
        A,
        states=STATES,
        inputs={"u": random.standard_normal(5)},
        noises={f"w{i}": 0.3 * column for i, column in enumerate(random.standard_normal((5, 5)))},
        dt=0.05,
    )
    measurements = [
        MeasurementModel(
            name,
            name,
            random.standard_normal(5),
            random.uniform(0.1, 1.0),
            scale_state=2 if name == "scaled" else None,
            is_gated=name != "ungated",
        )
        for name in SENSORS
    ]
    slack = Slack(random.standard_normal(5), random.uniform(0.0, 1.0, len(SENSORS)), 1, 2.0, 0.1, 0.05)
    drag = Drag(1, inertia=2.0, damping=0.1, quadratic=0.5, tick_period=0.05)
    with mock.patch.object(estimator_module, "KalmanFilter", ReferenceKalmanFilter if is_peer else KalmanFilter):
        return KalmanEstimator(
            model,
            measurements,
            np.eye(5),
            gate=9.0,
            gate_limit=3,
            largest_age=4,
            drag=None if linear else drag,
            slack=None if linear else slack,
        )


readings = st.builds(
    lambda name, value, age, sigma, offset, lever: (name, value, age, sigma, offset, lever),
    st.sampled_from(SENSORS),
    st.one_of(st.floats(-3.0, 3.0), st.sampled_from([100.0, 101.0, math.nan, math.inf, 1e200])),
    st.one_of(st.just(0), st.integers(-1, 6)),
    st.one_of(st.none(), st.floats(0.1, 1.0)),
    st.one_of(st.just(0.0), st.floats(-0.5, 0.5)),
    st.one_of(st.just({}), st.fixed_dictionaries({"lever": st.floats(-0.2, 0.2), "not_a_state": st.just(1.0)})),
)
"""Readings of any sensor: near its prediction or absurd, up to more than the buffer late, stated noise or not."""

ticks = st.lists(st.tuples(st.integers(1, 3), st.floats(-1.0, 1.0), st.lists(readings, max_size=7)), max_size=25)
"""Ticks with what was left out before them, command, and readings: more of one than there is place for at first."""


def recorded(told):
    """Return a list of ticks as a record."""
    record, number = [], 0
    for step, command, delivered in told:
        number += step
        taken = tuple(
            Measurement(name, value, number - age, sigma, offset, lever)
            for name, value, age, sigma, offset, lever in delivered
        )
        record.append(RecordedTick(number, command, taken))
    return record


@settings(max_examples=150, deadline=None)
@given(told=ticks, seed=st.integers(0, 2**16), linear=st.booleans())
def test_the_compiled_filter_estimates_and_judges_as_the_reference_does(told, seed, linear):
    """Late readings, missing and absurd ones, streams, bilinear scales, weights of other states, another noise.

    filterpy takes readings one after the other, the compiled filter those of a tick at once.
    """
    ours, peer = estimator(seed, linear=linear), estimator(seed, linear=linear, is_peer=True)
    for tick in recorded(told):
        for one in (ours, peer):
            one.step(tick.number, tick.command, tick.readings)
            if tick.number % 5 == 0:
                one.set_process_noise((1.0 + tick.number) * 0.1 * np.eye(5))
        scale = 1.0 + np.max(np.abs(peer.estimate))
        np.testing.assert_allclose(ours.estimate, peer.estimate, rtol=0.0, atol=1e-9 * scale)
        np.testing.assert_allclose(
            ours.covariance, peer.covariance, atol=1e-9 * (1.0 + np.max(np.abs(peer.covariance)))
        )
        assert list(ours.innovations) == list(peer.innovations)
        for name, innovation in ours.innovations.items():
            assert innovation.accepted == peer.innovations[name].accepted
            assert innovation.value == pytest.approx(peer.innovations[name].value, rel=1e-8, abs=1e-8, nan_ok=True)
            assert innovation.nis == pytest.approx(peer.innovations[name].nis, rel=1e-6, abs=1e-8, nan_ok=True)
        assert ours.refusals == peer.refusals
        assert ours.streams == pytest.approx(peer.streams, rel=1e-8, abs=1e-8)


@pytest.mark.parametrize(
    ("read", "used"),
    [
        ([0.0, 4.5, 9.5, 17.0], [True, True, True, True]),
        ([0.0, 4.5, 17.0, 17.0], [True, True, False, False]),
    ],
    ids=["goes on", "jump"],
)
def test_a_sensor_that_goes_on_from_its_last_reading_is_right_however_fast_the_model_leaves_it(read, used):
    """A load that struck the seabed left the model behind; its depth was refused, right as it was, for ten seconds."""
    still = linear_model(np.eye(1), states=("x",), inputs={"u": [0.0]}, noises={"w": [1e-3]}, dt=0.05)
    one = KalmanEstimator(still, [MeasurementModel("x", "x", np.ones(1), 1.0)], 1e-4 * np.eye(1), gate=25.0)
    accepted = []
    for tick, value in enumerate(read):
        one.step(tick, 0.0, [Measurement("x", value, tick)])
        accepted.append(one.innovations["x"].accepted)
    assert accepted == used


@settings(max_examples=30, deadline=None)
@given(told=ticks, seed=st.integers(0, 2**16))
def test_a_record_gives_to_the_bit_what_its_ticks_give_one_by_one(told, seed):
    stepped, followed = (estimator(seed, linear=False) for _ in range(2))
    innovations = []
    for tick in recorded(told):
        stepped.step(tick.number, tick.command, tick.readings)
        innovations.append(stepped.innovations)
    assert str(followed.follow(recorded(told))) == str(innovations)
    np.testing.assert_array_equal(followed.estimate, stepped.estimate)
    np.testing.assert_array_equal(followed.covariance, stepped.covariance)


def test_josephs_form_with_the_optimal_gain_is_the_short_form():
    """P - K H P, true for the optimal gain alone (Simon 2006, Eq. 5.19)."""
    rng = np.random.default_rng(4)
    root, H, variances = rng.standard_normal((6, 6)), rng.standard_normal((2, 6)), np.array([0.3, 0.7])
    P = root @ root.T
    K = filter_gain(P, H, variances)
    np.testing.assert_allclose(corrected_covariance(P, K, H, variances), P - K @ H @ P, atol=1e-12 * np.max(P))


def test_an_estimate_that_was_given_is_never_changed():
    """Whoever keeps an estimate keeps that of its tick, also when a reading of that tick comes late."""
    kalman, kept = estimator(1, linear=False), []
    for number in range(1, 12):
        late = Measurement("heave", 0.1 * number, max(number - 2, 1))
        kalman.step(number, 0.3, [late])
        kept.append((kalman.estimate, kalman.covariance, kalman.estimate.copy(), kalman.covariance.copy()))
    for x, P, x_then, P_then in kept:
        np.testing.assert_array_equal(x, x_then)
        np.testing.assert_array_equal(P, P_then)
