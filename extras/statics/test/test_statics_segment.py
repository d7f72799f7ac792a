import numpy as np
import pytest
from heave_statics.segment import segment_span
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

COMPONENT = st.floats(-1.0, 1.0).map(lambda value: round(value, 6))
VECTOR = st.tuples(COMPONENT, COMPONENT, COMPONENT)
STIFFNESS = 2.0e4


def span_of(start, load, length):
    span, by_tension, by_load = np.empty(3), np.empty((3, 3)), np.empty((3, 3))
    energy = segment_span(
        np.asarray(start, float), np.asarray(load, float), length, STIFFNESS, span, by_tension, by_load
    )
    return span, by_tension, by_load, energy


def away_from_zero(start, load, length, floor):
    """Whether the tension vector `start - load s` stays clear of zero along the segment."""
    square = float(load @ load)
    nearest = np.clip(start @ load / square, 0.0, length) if square > 0.0 else 0.0
    return np.linalg.norm(start - load * nearest) > floor


@settings(max_examples=80, deadline=None)
@given(VECTOR, VECTOR, st.floats(0.1, 50.0), st.floats(-5.0, 2.0))
def test_span_is_the_integral_of_the_strained_direction(start, load, length, magnitude):
    tension, load = 50.0 * np.array(start), 10.0**magnitude * np.array(load)
    if not away_from_zero(tension, load, length, 1.0):
        return
    span, _, _, energy = span_of(tension, load, length)

    def direction(s, axis):
        at = tension - load * s
        return at[axis] * (1.0 / np.linalg.norm(at) + 1.0 / STIFFNESS)

    expected = [quad(direction, 0.0, length, args=(axis,), epsabs=1e-11, limit=300)[0] for axis in range(3)]
    assert span == pytest.approx(expected, abs=1e-8 * length)
    pull = quad(lambda s: float(np.linalg.norm(tension - load * s)), 0.0, length, limit=300)[0]
    assert energy == pytest.approx(pull, rel=1e-8)


@settings(max_examples=80, deadline=None)
@given(VECTOR, VECTOR, st.floats(0.5, 20.0), st.floats(-6.0, 1.0))
def test_derivatives_are_those_of_finite_differences(start, load, length, magnitude):
    tension, load = 30.0 * np.array(start), 10.0**magnitude * np.array(load)
    if not away_from_zero(tension, load, length, 2.0):
        return
    _, by_tension, by_load, _ = span_of(tension, load, length)
    step = 1e-4
    for axis, unit in enumerate(np.eye(3)):
        change = span_of(tension + step * unit, load, length)[0] - span_of(tension - step * unit, load, length)[0]
        assert by_tension[:, axis] == pytest.approx(change / (2.0 * step), abs=2e-6 * length)
        small = step / length
        change = span_of(tension, load + small * unit, length)[0] - span_of(tension, load - small * unit, length)[0]
        assert by_load[:, axis] == pytest.approx(change / (2.0 * small), abs=2e-6 * length**2)


@settings(max_examples=60, deadline=None)
@given(VECTOR, VECTOR, st.floats(0.1, 20.0))
def test_compliance_is_symmetric_and_never_negative(start, load, length):
    tension, load = 20.0 * np.array(start), 5.0 * np.array(load)
    if np.linalg.norm(tension) < 1e-3:
        return
    compliance = span_of(tension, load, length)[1]
    scale = np.abs(compliance).max()
    assert compliance == pytest.approx(compliance.T, abs=1e-6 * scale)
    assert np.linalg.eigvalsh(0.5 * (compliance + compliance.T)).min() >= -1e-6 * scale


def test_a_weightless_segment_is_a_straight_bar():
    # the limit W -> 0 that thesis Eq. 2.31-2.33 divide by
    span = span_of([30.0, -40.0, 0.0], [0.0, 0.0, 0.0], 10.0)[0]
    assert span == pytest.approx(10.0 * (1.0 + 50.0 / STIFFNESS) * np.array([0.6, -0.8, 0.0]), rel=1e-15)


@pytest.mark.parametrize("weight", [1e-12, 1e-9, 1e-6, 1e-3])
def test_the_span_goes_smoothly_to_the_weightless_one(weight):
    straight = span_of([30.0, -40.0, 5.0], [0.0, 0.0, 0.0], 10.0)[0]
    span = span_of([30.0, -40.0, 5.0], [0.0, 0.0, -weight], 10.0)[0]
    # first order in w l / T
    assert np.abs(span - straight).max() <= 10.0 * weight * 10.0 / 50.0


def test_a_segment_that_hangs_folded_on_a_vertical_line_has_a_finite_span():
    # tension -5 N at one end and +5 N at the other: half of it hangs down, half comes up again
    span, compliance, _, energy = span_of([0.0, 0.0, -5.0], [0.0, 0.0, -1.0], 10.0)
    assert span == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)
    assert np.all(np.isfinite(compliance))
    assert energy == pytest.approx(25.0, rel=1e-12)
