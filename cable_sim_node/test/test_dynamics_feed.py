"""Cable in and out at the sheave: mass kept, no jump in tension, material below at rest."""

import dataclasses

import numpy as np
import pytest
from cable_sim_node.errors import CableTooShortError
from cable_sim_node.line import layout as at
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.parameters import CableSimParameters, ClumpsParameters, SectionsParameters
from heave_node.numerics.kinematics import PointMotion
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.validation.peers.driven_run import first_harmonic, ramped_sine
from tests.validation.peers.reference_systems import s300

STILL = PointMotion()


def ramp(t, rate, rise=20.0):
    """Return payout [m] and rate [m/s] of a winch that starts smoothly within `rise` seconds."""
    s = min(t / rise, 1.0)
    area = rise * (2.5 * s**4 - 3.0 * s**5 + s**6)
    return rate * (area + max(t - rise, 0.0)), rate * s**3 * (10.0 - 15.0 * s + 6.0 * s * s)


def feed(plant, rate, duration, tick=0.05, observe=lambda plant: None):
    for k in range(round(duration / tick)):
        plant.advance(tick, STILL, STILL, *ramp(k * tick, rate), *ramp((k + 1) * tick, rate))
        observe(plant)


def line_mass(plant):
    """Mass of cable and lumps in the equations of motion [kg]."""
    n, line = plant.segments, plant._line
    return float(line.column(at.MASS, n) @ line.column(at.LENGTH, n)) + float(np.sum(line.column(at.LUMP_MASS, n + 1)))


@pytest.mark.parametrize("segments", [20, 100])
@pytest.mark.parametrize("rate", [1.0, -1.0])
def test_tension_does_not_jump_when_nodes_are_born_or_die(segments, rate):
    """In one tick tension changes by the weight of the cable fed and little else: 1e-4 of it, in a current."""
    plant = CableDynamics(s300(segments, (0.3, 0.0)))
    plant.start_at_equilibrium(np.zeros(3))
    tensions, counts = [], []
    feed(plant, rate, 100.0, observe=lambda p: (tensions.append(p.top_tension), counts.append(p.segments)))
    events = np.flatnonzero(np.diff(counts))
    assert len(events) >= 5
    bend = np.abs(np.diff(tensions, 2))
    assert max(bend[max(e - 2, 0) : e + 4].max() for e in events) == pytest.approx(0.0, abs=1e-4 * tensions[0])


def test_the_line_arrives_where_it_would_have_hung():
    """After paying out 90 m and coming to rest, the line hangs as one that was started there."""
    plant = CableDynamics(s300(20))
    plant.start_at_equilibrium(np.zeros(3))
    tick = 0.05
    for k in range(4000):
        t0, t1 = k * tick, (k + 1) * tick
        ends = [
            (90.0 * s**3 * (10 - 15 * s + 6 * s * s), 90.0 * 30.0 * s**2 * (1 - s) ** 2 / 150.0)
            for s in (min(t0 / 150.0, 1.0), min(t1 / 150.0, 1.0))
        ]
        plant.advance(tick, STILL, STILL, *ends[0], *ends[1])
    rest = CableDynamics(s300(20))
    rest.start_at_equilibrium(np.zeros(3), 90.0)
    assert plant.unstretched_length == pytest.approx(390.0, abs=1e-9)
    assert plant.unit_position == pytest.approx(rest.unit_position, abs=2e-3)
    assert plant.top_tension == pytest.approx(rest.top_tension, rel=1e-3)


def test_a_winch_that_follows_the_boom_tip_leaves_the_line_at_rest():
    """The top heaves 1 m and the winch feeds the same stretched length: tension swings by the weight of the extra
    metre, 35.5 N.
    """
    plant = CableDynamics(s300(20))
    plant.start_at_equilibrium(np.zeros(3))
    top_strain = plant.top_tension / plant.parameters.cable.axial_stiffness
    motion, tick, omega = ramped_sine((0.0, 0.0, 1.0), 1.256, 30.0), 0.05, 1.256
    times, middle, tensions = [], [], []
    for k in range(2400):
        start, end = motion(k * tick), motion((k + 1) * tick)
        share = 1.0 / (1.0 + top_strain)
        plant.advance(
            tick,
            start,
            end,
            share * start.position[2],
            share * start.velocity[2],
            share * end.position[2],
            share * end.velocity[2],
        )
        if k > 1600:
            times.append(end.time)
            middle.append(plant.node_positions[10, 2])
            tensions.append(plant.top_tension)
    weight = plant.parameters.cable.weight_in_fluid(1025.0)
    assert first_harmonic(np.array(times), np.array(tensions), omega)[1] == pytest.approx(weight, rel=0.03)
    assert np.ptp(middle) < 2e-3


@settings(max_examples=25, deadline=None)
@given(
    rates=st.lists(st.floats(-2.0, 2.0), min_size=1, max_size=6),
    segments=st.integers(1, 40),
    with_sections=st.booleans(),
)
def test_mass_is_kept_through_payout_and_haul_in(rates, segments, with_sections):
    """The line's mass is that of the cable between unit and sheave, whatever nodes came and went."""
    parameters = CableSimParameters(length=120.0, segments=segments)
    extra = 0.0
    if with_sections:
        parameters = dataclasses.replace(
            parameters,
            sections=SectionsParameters(
                length=(40.0, 30.0), diameter=(0.06, 0.05), mass_per_length=(8.0, 2.0), axial_stiffness=(2e7, 1e7)
            ),
            clumps=ClumpsParameters(
                position=(25.0,), mass=(100.0,), volume=(0.02,), added_mass=(20.0,), drag_area=(0.1,)
            ),
        )
        extra = 100.0 + 40.0 * (8.0 - 5.4) + 30.0 * (2.0 - 5.4)
    plant = CableDynamics(parameters)
    plant.start_at_equilibrium(np.zeros(3))
    payout, rate = 0.0, 0.0
    for goal in rates:
        for _ in range(40):
            new = rate + 0.05 * np.clip((goal - rate) / 0.05, -1.5, 1.5)
            after = payout + 0.025 * (rate + new)
            if after < -45.0 or after > 60.0:
                break
            plant.advance(0.05, STILL, STILL, payout, rate, after, new)
            payout, rate = after, new
    assert line_mass(plant) == pytest.approx(5.4 * plant.unstretched_length + extra, rel=1e-9)
    assert plant.unstretched_length == pytest.approx(120.0 + payout, abs=1e-9)
    assert np.all(np.isfinite(plant.node_positions))


def test_sections_pass_the_sheave_and_tension_follows_their_weight():
    """A heavy section beyond the sheave comes out: tension grows by its own weight per metre, without a step."""
    parameters = dataclasses.replace(
        s300(20),
        sections=SectionsParameters(
            length=(320.0,), diameter=(0.047,), mass_per_length=(5.4,), axial_stiffness=(1.5614508e7,)
        ),
    )
    parameters = dataclasses.replace(parameters, cable=dataclasses.replace(parameters.cable, mass_per_length=12.0))
    plant = CableDynamics(parameters)
    plant.start_at_equilibrium(np.zeros(3))
    tensions = []
    feed(plant, 1.0, 120.0, observe=lambda p: tensions.append(p.top_tension))
    steady = np.diff(tensions)[600:]
    assert np.max(np.abs(np.diff(steady))) < 3.0
    # 1 m/s at 20 Hz: 5 cm a tick
    assert np.mean(steady[-400:]) == pytest.approx(0.05 * parameters.cable.weight_in_fluid(1025.0), rel=0.1)


def test_hauling_in_below_one_segment_is_named():
    plant = CableDynamics(s300(4))
    plant.start_at_equilibrium(np.zeros(3))
    with pytest.raises(CableTooShortError, match=r"at t = .* m of cable is left"):
        feed(plant, -4.0, 100.0)
    assert np.all(np.isfinite(plant.node_positions))
    assert 25.0 < plant.unstretched_length < 35.0


def test_payout_far_beyond_the_grid_only_makes_it_grow():
    plant = CableDynamics(s300(10))
    plant.start_at_equilibrium(np.zeros(3))
    feed(plant, 2.0, 500.0, tick=0.1)
    assert plant.unstretched_length == pytest.approx(300.0 + ramp(500.0, 2.0)[0])
    assert plant.segments > 40
    assert plant.unit_position[2] < -plant.unstretched_length
