"""The thesis's examples (chapters 3 and 5) and Pinto's towed cable on the three-dimensional solver.

Figures are not digitised: where an example has an exact or limiting solution it is compared with that, elsewhere the
stated trend is asserted.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.parameters import CableParameters, CableSimParameters, SolverParameters, UnitParameters
from heave_node.numerics.kinematics import PointMotion

from tests.validation.peers.driven_run import first_harmonic, lower, ramped_sine, run_driven, smooth_rise, smooth_start
from tests.validation.peers.moordyn import RK2, run_moordyn
from tests.validation.peers.reference_systems import s300


def rope(diameter, length, modulus, mass_per_length, mass, time_step):
    """Return a laboratory rope in air with a weight at its end."""
    area = 0.25 * math.pi * diameter**2
    return CableSimParameters(
        length=length,
        segments=10,
        water_density=0.0,
        cable=CableParameters(diameter=diameter, mass_per_length=mass_per_length, axial_stiffness=modulus * area),
        unit=UnitParameters(mass=mass, volume=0.0, added_mass=(0.0,) * 3),
        solver=SolverParameters(time_step=time_step),
    )


def bar_tension(parameters, omega):
    """Return the exact top tension amplitude per metre of top heave of an undamped elastic bar with an end mass."""
    cable, mass = parameters.cable, parameters.unit.mass
    k = omega * math.sqrt(cable.mass_per_length / cable.axial_stiffness)
    slope = mass * omega**2 / (cable.axial_stiffness * k)
    angle = k * parameters.length
    return (
        cable.axial_stiffness
        * k
        * (math.sin(angle) + slope * math.cos(angle))
        / (math.cos(angle) - slope * math.sin(angle))
    )


POLYESTER = rope(0.003, 4.573, 3.38e9, 8.067e-3, 4.722, 0.002)
POLYESTER_8 = rope(0.002, 4.573, 2.445e9, 4.155e-3, 4.722, 0.002)
NYLON = rope(0.00635, 22.25, 2.67e8, 3.23e-2, 12.65, 0.005)


@pytest.mark.parametrize(
    ("parameters", "amplitude", "omegas"),
    [(POLYESTER, 0.05, (2.0, 6.0, 10.0)), (POLYESTER_8, 0.1, (2.0, 5.0, 8.0)), (NYLON, 0.0254, (2.0, 4.5, 7.0, 9.0))],
)
def test_chapter_3_examples_1_to_3_in_air_are_the_elastic_bars(parameters, amplitude, omegas):
    """Maximum tension against frequency; undamped, so exact."""
    for omega in omegas:
        period = 2.0 * math.pi / omega
        result = run_driven(
            parameters,
            (0.0, 0.0, amplitude),
            omega,
            duration=30.0 * period,
            window=10.0 * period,
            ramp=20.0 * period,
            tick=period / 60.0,
        )
        exact = amplitude * abs(bar_tension(parameters, omega))
        weight = 9.80665 * (parameters.unit.mass + parameters.cable.mass_per_length * parameters.length)
        assert result.tension_amplitude == pytest.approx(exact, rel=0.01)
        assert result.tension_max == pytest.approx(weight + exact, rel=0.01)


def lowering(speed, omega, *, start, stop, parameters, amplitude=(0.0, 0.0, 1.0), tick=0.1):
    """Lower at `speed` from `start` to `stop` metres while the top heaves; return lengths and the unit's positions."""
    plant = CableDynamics(dataclasses.replace(parameters, length=start))
    plant.start_at_equilibrium(np.zeros(3))
    return lower(plant, ramped_sine(amplitude, omega, 20.0), speed, stop, tick)


def heave_about_the_mean(lengths, z, omega, tick=0.1):
    """Return z with a running mean over one period (steady lowering, stretch, drag) taken away."""
    width = round(2.0 * math.pi / omega / tick)
    mean = np.convolve(z, np.ones(width) / width, mode="same")
    keep = slice(width, -width)
    return lengths[keep], (z - mean)[keep]


DEPLOYED = CableSimParameters(
    segments=3,
    cable=CableParameters(diameter=0.047, mass_per_length=7.2, axial_stiffness=9.05e9 * 0.25 * math.pi * 0.047**2),
    unit=UnitParameters(
        mass=5000.0, volume=1.0, added_mass=(8000.0,) * 3, drag_coefficient=(1.0,) * 3, drag_area=(1.0,) * 3
    ),
)


def test_chapter_3_example_5_faster_lowering_means_less_motion(gallery):
    """1.260 rad/s: resonance near L = EA/(w^2 (M + Ma)) = 761 m, a third of the cable added to M; the motion falls with
    speed, the critical length grows.
    """
    omega, results = 1.26, {}
    for speed in (0.5, 1.0, 2.0, 3.0):
        lengths, units = lowering(speed, omega, start=50.0, stop=1000.0, parameters=DEPLOYED, amplitude=(0.0, 0.0, 0.2))
        results[speed] = heave_about_the_mean(lengths, units[:, 2], omega)

    def draw(figure):
        for axes, (speed, (lengths, heave)) in zip(figure.subplots(4, 1, sharex=True), results.items(), strict=True):
            axes.plot(lengths, heave, linewidth=0.6)
            axes.set_ylabel(f"{speed} m/s")
        axes.set_xlabel("cable length [m]")

    gallery(
        "chapter3_example5", "Thesis 3.3.5: unit heave [m] against length at four lowering speeds, 1.26 rad/s.", draw
    )
    largest = [float(np.max(np.abs(heave))) for _, heave in results.values()]
    assert largest == sorted(largest, reverse=True)
    where = [float(lengths[np.argmax(np.abs(heave))]) for lengths, heave in results.values()]
    assert where[0] == pytest.approx(761.0 * 13.0 / (13.0 + 7.2 * 0.67 / 3.0), rel=0.1)
    assert where[3] > where[0]
    # short cable: the unit follows the top
    lengths, heave = results[0.5]
    assert np.max(np.abs(heave[(lengths > 65.0) & (lengths < 80.0)])) == pytest.approx(0.2, abs=0.06)


def loop_turn(speed):
    """Return the tow point's motion: still, then `speed` along x for 800 m, a full circle of 300 m diameter,
    straight on.
    """
    rise, radius, straight = 30.0, 150.0, 800.0

    def motion(t):
        way, rate = (speed * one for one in smooth_start(t, rise))
        turn = 2.0 * math.pi * radius
        if straight < way < straight + turn:
            angle = (way - straight) / radius
            position = (straight + radius * math.sin(angle), radius * (1.0 - math.cos(angle)), 0.0)
            heading = (math.cos(angle), math.sin(angle), 0.0)
        else:
            position = (way if way <= straight else way - turn, 0.0, 0.0)
            heading = (1.0, 0.0, 0.0)
        return PointMotion(t, np.array(position), rate * np.array(heading), np.zeros(3))

    return motion


def tow(parameters, speed, duration, tick=0.1):
    plant = CableDynamics(parameters)
    plant.start_at_equilibrium(np.zeros(3))
    motion = loop_turn(speed)
    tips, units = [], []
    for k in range(round(duration / tick)):
        plant.advance(tick, motion(k * tick), motion((k + 1) * tick), 0.0, 0.0, 0.0, 0.0)
        tips.append(motion((k + 1) * tick).position)
        units.append(plant.unit_position)
    return np.array(tips), np.array(units)


@pytest.mark.parametrize("speed", [2.0, 4.0])
def test_chapter_5_loop_turn_in_water(speed):
    """Straight tow is the equilibrium in the opposite current (Galilei); the unit cuts the corner and comes back
    to it.
    """
    duration = (800.0 + 2.0 * math.pi * 150.0 + 1500.0) / speed
    tips, units = tow(s300(20, time_step=0.1), speed, duration)

    steady = CableDynamics(s300(20, (-speed, 0.0)))
    steady.start_at_equilibrium(np.zeros(3))
    before = round((780.0 / speed) / 0.1)
    # the faster tow has had less time to settle
    assert units[before] - tips[before] == pytest.approx(steady.unit_position, abs=10.0)
    assert units[-1] - tips[-1] == pytest.approx(steady.unit_position, abs=3.0)
    assert 0.0 < np.max(units[:, 1]) < 300.0
    assert np.min(units[:, 1]) > -60.0


def test_chapter_5_loop_turn_in_air_swings_outward_and_goes_on_swinging():
    """No drag: the unit is thrown outward by the turn, and nothing damps what is left."""
    air = dataclasses.replace(s300(20, time_step=0.1, spectral_radius=1.0), water_density=0.0)
    tips, units = tow(air, 4.0, 900.0)
    wet_tips, wet_units = tow(s300(20, time_step=0.1), 4.0, 900.0)
    assert np.max(units[:, 1]) > np.max(wet_units[:, 1])
    relative = (units - tips)[:, 1]
    swings = [float(np.ptp(part)) for part in (relative[-1600:-800], relative[-800:])]
    assert swings[1] == pytest.approx(swings[0], rel=0.1)
    assert swings[1] > 3.0 * float(np.ptp((wet_units - wet_tips)[-800:, 1]))


# --- Pinto: a towed light-armoured cable (table 1), without a body at its end

LIGHT = CableParameters(
    diameter=0.0264,
    displaced_diameter=math.sqrt(4.0 * (1.64 - 10.96 / 9.80665) / (math.pi * 1025.0)),
    mass_per_length=1.64,
    axial_stiffness=1.5e7,
    bending_stiffness=500.0,
    normal_drag=2.12,
    tangential_drag=0.01,
)


def bare(length, segments, speed):
    """Return the cable hanging in a current against the tow, its end body as good as nothing."""
    return CableSimParameters(
        length=length,
        segments=segments,
        current=(-speed, 0.0),
        cable=LIGHT,
        unit=UnitParameters(mass=0.5, volume=0.0, added_mass=(0.0,) * 3, drag_coefficient=(0.0,) * 3),
        solver=SolverParameters(time_step=0.1),
    )


def critical_angle(speed):
    """Return the angle to the horizontal where drag across balances weight across: (1/2) rho C d V^2 sin^2 a = w
    cos a.
    """
    drag = 0.5 * 1025.0 * 2.12 * 0.0264 * speed**2 / 10.96
    return math.acos((math.sqrt(1.0 + 4.0 * drag**2) - 1.0) / (2.0 * drag))


def test_pintos_equation_15_is_inverted_a_tight_cable_is_longer():
    """dp/ds = 1 + e on the light cable towed at 1 m/s, made soft; printed 1/(1 + e)."""
    parameters = bare(500.0, 25, 1.0)
    soft = dataclasses.replace(LIGHT, axial_stiffness=1e5)
    plant = CableDynamics(dataclasses.replace(parameters, cable=soft))
    plant.start_at_equilibrium(np.zeros(3))
    ratio = np.linalg.norm(np.diff(plant.node_positions, axis=0), axis=1) / np.diff(plant.material_coordinates)
    strain = plant.segment_tensions / 1e5
    assert strain[-1] > 0.01
    assert ratio == pytest.approx(1.0 + strain, abs=1e-9)
    assert abs(ratio[-1] * (1.0 + strain[-1]) - 1.0) > 0.02


@pytest.mark.parametrize(("slow", "fast"), [(0.5, 1.0), (1.0, 0.5)])
def test_pintos_towed_cable_speeds_up_and_slows_down_to_the_straight_line(slow, fast):
    """The ship changes speed; the cable ends on the straight line of the new speed, its slope exact."""
    plant = CableDynamics(bare(500.0, 25, slow))
    plant.start_at_equilibrium(np.zeros(3))

    def motion(t):
        way, rate = ((fast - slow) * one for one in smooth_start(t, 60.0))
        return PointMotion(t, np.array([way, 0.0, 0.0]), np.array([rate, 0.0, 0.0]))

    def slope():
        x = plant.node_positions
        d = x[-1] - x[2]
        return math.atan2(d[2], math.hypot(d[0], d[1]))

    assert slope() == pytest.approx(critical_angle(slow), abs=0.03)
    for k in range(20000):
        plant.advance(0.2, motion(0.2 * k), motion(0.2 * (k + 1)), 0.0, 0.0, 0.0, 0.0)
        if k % 500 == 499 and k > 8000 and np.max(np.abs(plant.node_velocities - plant.node_velocities[-1])) < 1e-3:
            break
    assert slope() == pytest.approx(critical_angle(fast), abs=0.03)


def in_pintos_wave(t, tow=0.0):
    """Return the boom tip in a wave of 3 m, 10 s with his RAO, surge 0.708 at -45.9 deg and heave 1.619, on a `tow`.

    Wave and speed of the tow [m/s] rise within 30 s.
    """
    omega = 2.0 * math.pi / 10.0
    rise, slope = smooth_rise(t / 30.0)
    sizes, phases = np.array([3.0 * 0.708, 0.0, 3.0 * 1.619]), np.array([math.radians(-45.9), 0.0, 0.0])
    sine, cosine = np.sin(omega * t + phases), np.cos(omega * t + phases)
    way, _ = smooth_start(t, 30.0)
    towed = np.array([tow, 0.0, 0.0])
    velocity = sizes * (slope / 30.0 * sine + rise * omega * cosine) + rise * towed
    return PointMotion(t, sizes * rise * sine + way * towed, velocity)


def test_pintos_wave_slackens_the_light_cable_and_refinement_agrees():
    """Heave of 4.9 m; tension stays above zero."""
    motion, peaks = in_pintos_wave, []
    for segments in (25, 50):
        plant = CableDynamics(bare(500.0, segments, 1.0))
        plant.start_at_equilibrium(motion(0.0).position)
        static, tensions = plant.top_tension, []
        for k in range(1200):
            plant.advance(0.05, motion(0.05 * k), motion(0.05 * (k + 1)), 0.0, 0.0, 0.0, 0.0)
            tensions.append(plant.top_tension)
        late = np.array(tensions[800:])
        assert late.min() >= 0.0
        assert late.max() > 1.5 * static
        peaks.append(late.max())
    assert peaks[0] == pytest.approx(peaks[1], rel=0.05)


def test_pintos_wave_pulls_the_light_cable_as_in_moordyn():
    """Figure 5 without bending, at 1 m/s: the plant in the current against the tow, MoorDyn on the tow in still water.

    MoorDyn takes the top's speed as constant over a tick, and each step of it pulls by sqrt(EA m) times the step: hence
    ticks of 10 ms. Its cable starts as a chord and takes 400 s to settle.
    """
    pytest.importorskip("moordyn")
    parameters = dataclasses.replace(
        bare(500.0, 50, 1.0),
        cable=dataclasses.replace(LIGHT, bending_stiffness=0.0),
        unit=UnitParameters(mass=0.5, volume=1e-4, added_mass=(0.0,) * 3, drag_coefficient=(0.0,) * 3),
        surface=False,
    )
    peer = run_moordyn(parameters, lambda t: in_pintos_wave(t, 1.0), duration=400.0, tick=0.01, setting=RK2)
    plant = CableDynamics(parameters)
    plant.start_at_equilibrium(np.zeros(3))
    tensions = []
    for k in range(8000):
        plant.advance(0.05, in_pintos_wave(0.05 * k), in_pintos_wave(0.05 * (k + 1)), 0.0, 0.0, 0.0, 0.0)
        tensions.append(plant.top_tension)
    times, own, other = peer.times[4::5][-800:], np.array(tensions)[-800:], peer.tension[4::5][-800:]
    mean, size, phase = first_harmonic(times, own, 2.0 * math.pi / 10.0)
    peer_mean, peer_size, peer_phase = first_harmonic(times, other, 2.0 * math.pi / 10.0)
    assert mean == pytest.approx(peer_mean, rel=0.01)
    assert size == pytest.approx(peer_size, rel=0.01)
    assert phase == pytest.approx(peer_phase, abs=0.01)
    assert own.max() == pytest.approx(other.max(), rel=0.015)
