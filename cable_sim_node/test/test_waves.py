"""The water under waves: Airy's formulae for deep water written out here, and what the water does to a body in it."""

import dataclasses
import math

import numpy as np
import pytest
from cable_sim_node.component import CableSim
from cable_sim_node.errors import PlantError
from cable_sim_node.line import layout as at
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.line.forces.waves import add_waves, surface_at
from cable_sim_node.line.grid import build_line, with_waves
from cable_sim_node.node_parameters import CableSimNodeParameters
from cable_sim_node.parameters import CableParameters, CableSimParameters, WaveKinematicsParameters
from cable_sim_node.unit_parameters import UnitParameters
from heave_node.interface.waves import NO_WAVES, Waves
from heave_node.numerics.compiled import kernel
from heave_node.numerics.constants import STANDARD_GRAVITY
from heave_node.numerics.kinematics import PointMotion

AMPLITUDE, PERIOD, DIRECTION, PHASE = 1.3, 7.0, 0.6, 0.4
OMEGA = 2.0 * math.pi / PERIOD
PLACES = [(0.0, 0.0, -3.0, 0.0), (12.0, -7.0, -1.0, 2.3), (-40.0, 5.0, -20.0, 31.0), (3.0, 2.0, 0.5, 8.0)]


def one_wave(**changed):
    columns = {
        "frequency": OMEGA,
        "encounter_frequency": OMEGA,
        "amplitude": AMPLITUDE,
        "phase": PHASE,
        "direction": DIRECTION,
    }
    times = {name: changed.pop(name) for name in ("start", "ramp") if name in changed}
    return Waves(**{name: np.array([value]) for name, value in (columns | changed).items()}, **times)


@kernel
def water_at(line, x, y, z, time):
    tile = line.tiles[0]
    tile[at.FLOW_X] = tile[at.FLOW_Y] = tile[at.FLOW_Z] = 0.0
    add_waves(line, x, y, z, time, tile, 0)
    velocity = tile[at.FLOW_X], tile[at.FLOW_Y], tile[at.FLOW_Z]
    return velocity, (tile[at.FLOW_AX], tile[at.FLOW_AY], tile[at.FLOW_AZ]), surface_at(line, x, y, time)


def line_in(waves):
    return with_waves(build_line(CableSimParameters(length=10.0, segments=2), 20.0), waves)


def by_hand(x, y, z, time, **changed):
    """Velocity, acceleration, and elevation with its rate: the derivatives of the potential (g a/omega) e^{kz} sin."""
    wave = one_wave(**changed)
    omega, direction = float(wave.frequency[0]), float(wave.direction[0])
    k = omega**2 / STANDARD_GRAVITY
    theta = omega * time - k * (x * math.cos(direction) + y * math.sin(direction)) + float(wave.phase[0])
    speed = float(wave.amplitude[0]) * omega * math.exp(k * min(z, 0.0))
    along = np.array([math.cos(direction), math.sin(direction), 0.0])
    up = np.array([0.0, 0.0, 1.0])
    velocity = speed * (math.cos(theta) * along - math.sin(theta) * up)
    acceleration = -omega * speed * (math.sin(theta) * along + math.cos(theta) * up)
    surface = float(wave.amplitude[0]) * np.array([math.cos(theta), -omega * math.sin(theta)])
    return velocity, acceleration, surface


@pytest.mark.parametrize("place", PLACES)
def test_one_component_is_the_wave_of_airy(place):
    for found, expected in zip(water_at(line_in(one_wave()), *place), by_hand(*place), strict=True):
        assert np.array(found) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("place", PLACES)
def test_components_add(place):
    other = {"frequency": 0.5, "encounter_frequency": 0.5, "amplitude": 0.7, "phase": 2.0, "direction": -2.0}
    pairs = zip(one_wave().columns, one_wave(**other).columns, strict=True)
    both = Waves(*(np.concatenate(pair) for pair in pairs))
    parts = zip(by_hand(*place), by_hand(*place, **other), strict=True)
    for found, (first, second) in zip(water_at(line_in(both), *place), parts, strict=True):
        assert np.array(found) == pytest.approx(first + second, abs=1e-12)


def test_crests_travel_with_g_over_omega():
    """Dispersion in deep water, omega^2 = g k: a crest is g t/omega further after a time t."""
    line, time = line_in(one_wave(phase=0.0, direction=0.0)), 5.0
    assert water_at(line, STANDARD_GRAVITY / OMEGA * time, 0.0, 0.0, time)[2][0] == pytest.approx(AMPLITUDE)


def test_the_ramp_grows_elevation_and_velocity_and_the_acceleration_is_the_velocitys_derivative():
    line, place, time, h = line_in(one_wave(start=2.0, ramp=10.0)), (5.0, 1.0, -2.0), 6.0, 1e-4
    x = (time - 2.0) / 10.0
    ramp = 10.0 * x**3 - 15.0 * x**4 + 6.0 * x**5
    velocity, acceleration, surface = water_at(line, *place, time)
    full = by_hand(*place, time - 2.0)
    assert np.array(velocity) == pytest.approx(ramp * full[0], abs=1e-12)
    assert surface[0] == pytest.approx(ramp * full[2][0])
    before, after = water_at(line, *place, time - h), water_at(line, *place, time + h)
    assert np.array(acceleration) == pytest.approx((np.array(after[0]) - before[0]) / (2.0 * h), abs=1e-6)
    assert surface[1] == pytest.approx((after[2][0] - before[2][0]) / (2.0 * h), abs=1e-6)
    assert water_at(line, *place, 2.0)[2] == (0.0, 0.0)


def test_what_reaches_no_deeper_is_left_out_and_nothing_else():
    """e^{-10} of the speed at the surface is all that is missed below the reach of a component."""
    k = OMEGA**2 / STANDARD_GRAVITY
    line = line_in(one_wave())
    for share, missed in ((9.9, 0.0), (10.1, math.exp(-10.0))):
        place = (0.0, 0.0, -share / k, 1.0)
        assert np.array(water_at(line, *place)[0]) == pytest.approx(
            by_hand(*place)[0], abs=AMPLITUDE * OMEGA * missed + 1e-15
        )


def test_a_sea_of_one_component_does_what_the_regular_wave_does():
    regular = WaveKinematicsParameters("regular", AMPLITUDE, PERIOD, DIRECTION)
    plain = CableSimParameters(length=40.0, segments=8)
    plants = [CableDynamics(dataclasses.replace(plain, wave=regular)), CableDynamics(plain)]
    tip = PointMotion(0.0, np.array([0.0, 0.0, 5.0]))
    for plant in plants:
        plant.start_at_equilibrium(tip.position)
    plants[1].set_waves(one_wave(phase=0.0))
    for _ in range(100):
        for plant in plants:
            plant.advance(0.05, tip, tip, 0.0, 0.0, 0.0, 0.0)
    assert np.ptp(plants[0].node_positions[:, 0]) > 0.01
    assert np.array_equal(plants[0].node_positions, plants[1].node_positions)
    assert plants[0].top_tension == plants[1].top_tension


MASS, VOLUME, ADDED, DENSITY = 5000.0, 2.0, 3000.0, 1025.0
FREE = UnitParameters(mass=MASS, volume=VOLUME, added_mass=(ADDED,) * 3, drag_coefficient=(0.0,) * 3)
THIN = CableParameters(diameter=0.001, mass_per_length=0.01, axial_stiffness=5e8, normal_drag=0.0, tangential_drag=0.0)


def test_a_wet_body_on_a_long_line_moves_with_the_water_by_its_inertia():
    """Without drag (rho V + A)/(M + A) of the water's amplitude, over 1 - (omega_0/omega)^2 of the pendulum it is.

    The pendulum: omega_0^2 = (M - rho V) g/((M + A) L). 10 s and 300 m, of which 10 m are in the water.
    """
    omega, length, amplitude, depth = 0.2 * math.pi, 300.0, 0.5, 10.0
    wave = one_wave(frequency=omega, encounter_frequency=omega, amplitude=amplitude, direction=0.0, ramp=400.0)
    plant = CableDynamics(CableSimParameters(length=length, segments=6, cable=THIN, unit=FREE))
    tip = PointMotion(0.0, np.array([0.0, 0.0, length - depth]))
    plant.start_at_equilibrium(tip.position)
    plant.set_waves(wave)
    places = []
    for _ in range(10_000):
        plant.advance(0.05, tip, tip, 0.0, 0.0, 0.0, 0.0)
        places.append(plant.unit_position[0])
    steady = np.array(places[-2000:])
    water = amplitude * math.exp(-(omega**2) / STANDARD_GRAVITY * depth)
    natural = (MASS - DENSITY * VOLUME) * STANDARD_GRAVITY / ((MASS + ADDED) * length)
    by_hand = water * (DENSITY * VOLUME + ADDED) / (MASS + ADDED) / (1.0 - natural / omega**2)
    assert 0.5 * np.ptp(steady) == pytest.approx(by_hand, rel=0.01)


def test_a_sea_that_has_no_components_is_refused_in_a_line():
    parameters = CableSimNodeParameters(wave=WaveKinematicsParameters("sea"))
    plant = CableSim(parameters, seed=1, tick_period=0.05)
    assert (plant.awaits_waves, plant.waves_missing) == (True, 0), "they come with the first tick"
    plant.advance(1, None, None)
    assert plant.waves_missing == 1
    with pytest.raises(PlantError, match=r"^cable_sim: wave.source = sea, but .* boom_tip_source[^\n]*$"):
        plant.set_waves(NO_WAVES)
    plant.set_waves(one_wave())
    assert (plant.awaits_waves, plant.waves_missing) == (False, 0)


def test_still_water_stays_still_whatever_the_sea():
    plant = CableSim(CableSimNodeParameters(), seed=1, tick_period=0.05)
    plant.set_waves(NO_WAVES)
    assert not plant.awaits_waves


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"amplitude": math.nan}, "not finite"),
        ({"start": math.inf}, "not finite"),
        ({"frequency": 0.0}, "above 0"),
        ({"ramp": -1.0}, "not negative"),
    ],
)
def test_numbers_that_are_of_no_wave_are_refused(changed, words):
    with pytest.raises(ValueError, match=words):
        one_wave(**changed)


@pytest.mark.parametrize("lengths", [(2, 1, 1, 1, 1), (30_000,) * 5])
def test_columns_of_different_or_absurd_length_are_refused(lengths):
    with pytest.raises(ValueError, match="columns of one length"):
        Waves(*(np.ones(length) for length in lengths))


@pytest.mark.parametrize(
    "values",
    [{"wave": {"amplitude": 1.0}}, {"model": "linear", "wave": {"source": "sea"}}],
)
def test_a_wave_without_its_source_and_a_sea_without_water_are_refused(values):
    wave = values.pop("wave")
    with pytest.raises(ValueError, match=r"wave\.source"):
        CableSimNodeParameters(wave=WaveKinematicsParameters(**wave), **values)


@pytest.mark.parametrize(
    ("wave", "words"),
    [
        ({}, "needs wave.amplitude; still water is wave.source = none"),
        # 80 m are 0.142 of the 563 m of a wave of 19.0 s
        ({"amplitude": 40.0, "period": 5.0}, "a height of 80 m needs a peak period of 19.0 s or more, got 5 s"),
    ],
)
def test_a_regular_wave_that_is_none_or_would_break_is_refused(wave, words):
    with pytest.raises(ValueError, match=words):
        WaveKinematicsParameters("regular", **wave)


def test_a_linear_plant_refuses_a_rope_whose_friction_it_does_not_have():
    with pytest.raises(ValueError, match=r"model = linear knows no cable\.loss_factor"):
        CableSimNodeParameters(model="linear", cable=CableParameters(loss_factor=0.05))
