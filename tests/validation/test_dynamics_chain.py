"""Dispersion by bending (thesis 12.4.6), the nonlinear chain (5.3.2, Eq. 5.20) and the plant's scheme.

No section prints a number. Eq. 5.20 takes the local T as constant and so loses a third of its nonlinear term, which is
3/(2 e) x'^2 and not (1/e) x'^2: the solitary wave is x' = A sech(k (s - V t)), (k l)^2 = 3 A^2/e,
V = c (1 + (k l)^2/24).
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.parameters import CableParameters, CableSimParameters, SolverParameters, UnitParameters
from heave_node.numerics.kinematics import PointMotion

from tests.validation.peers.driven_run import first_harmonic, ramped_sine

MU, TENSION = 5.4, 36_000.0


def wire(length, segments, time_step, *, stiffness=1.5e7, bending=0.0):
    """Return a weightless wire at uniform tension in vacuum, its unit too heavy to move."""
    cable = CableParameters(mass_per_length=MU, axial_stiffness=stiffness, added_mass=0.0, bending_stiffness=bending)
    unit = UnitParameters(mass=1e9, volume=0.0, drag_coefficient=(0.0,) * 3, thrust=(0.0, 0.0, -TENSION))
    solver = SolverParameters(time_step=time_step, spectral_radius=1.0, tolerance=1e-9)
    parameters = CableSimParameters(
        length=length, segments=segments, water_density=0.0, gravity=0.0, cable=cable, unit=unit, solver=solver
    )
    plant = CableDynamics(parameters)
    plant.start_at_equilibrium(np.zeros(3))
    return plant


def wave_number(omega, bending, *, length=160.0, segments=160):
    """Return the wave number [rad/m] of a wire driven sideways by 1 mm, read away from its top before echoes return."""
    period = 2.0 * math.pi / omega
    plant = wire(length, segments, period / 60.0, bending=bending)
    motion = ramped_sine((1e-3, 0.0, 0.0), omega, 3.0 * period)
    tick, times, nodes = period / 20.0, [], []
    for k in range(1, 161):
        plant.advance(tick, motion((k - 1) * tick), motion(k * tick), 0.0, 0.0, 0.0, 0.0)
        if k > 120:
            times.append(k * tick)
            nodes.append(plant.node_positions[::-1, 0])
    record, field = np.array(times), np.array(nodes)
    phases = np.unwrap([first_harmonic(record, field[:, j], omega)[2] for j in range(15, 35)])
    return -float(np.polyfit(np.arange(20), phases, 1)[0]) * segments / length


@pytest.mark.parametrize("bending", [0.0, 5e4, 1.5e5])
def test_bending_stiffness_disperses_transverse_waves_as_the_thesis_says(bending):
    """omega = k sqrt(T/mu + EI k^2/mu) of 12.4.6, at waves of 20 m: the stiffest wire's are 19 % faster."""
    k = 2.0 * math.pi / 20.0
    tension = TENSION / (1.0 + TENSION / 1.5e7)
    omega = k * math.sqrt(tension / MU + bending * k**2 / MU)
    assert wave_number(omega, bending) == pytest.approx(k, rel=0.01)


STRAIN, WIDTH = 2.4e-3, 0.5
"""Strain at rest, and k l of the solitary wave."""
SLOPE = WIDTH * math.sqrt(STRAIN / 3.0)
"""Its largest slope A."""


def kink(s):
    """Return the displacement whose slope is A sech(k s), in segment lengths."""
    return 2.0 * SLOPE / WIDTH * np.arctan(np.exp(WIDTH * np.asarray(s)))


def chain_moved(x, v, duration, dt=0.05):
    """Return the chain of unit masses, lengths and tension after a `duration`, each mass free along x alone.

    Units: segment length, mass, and T l/m = 1, so that the linear wave speed c is 1 segment per unit of time.
    """

    def pull(x):
        slope = np.diff(x)
        stretched = np.hypot(1.0 + STRAIN, slope)
        force = (stretched - 1.0) / STRAIN * slope / stretched * (1.0 + STRAIN)
        return np.concatenate(([0.0], np.diff(force), [0.0]))

    for _ in range(round(duration / dt)):
        v = v + 0.5 * dt * pull(x)
        x = x + dt * v
        v = v + 0.5 * dt * pull(x)
    return x, v


@pytest.mark.parametrize(("factor", "is_right"), [(1.0, True), (math.sqrt(1.5), False)])
def test_the_chain_in_one_direction_carries_the_solitary_wave_of_the_mkdv_equation(gallery, factor, is_right):
    """Eq. 5.20 with 3/(2 e): over 400 segments it keeps its height and runs at c (1 + (k l)^2/24).

    That of the printed 1/e is higher by sqrt(1.5): it does not keep its shape.
    """
    speed, duration = 1.0 + WIDTH**2 / 24.0, 400.0
    s = np.arange(700.0) - 100.0
    x = factor * kink(s)
    start = np.diff(x).max()
    moved, _ = chain_moved(x, -factor * speed * (kink(s + 1e-4) - kink(s - 1e-4)) / 2e-4, duration)
    slope = np.diff(moved)

    def draw(figure):
        axes = figure.subplots()
        axes.plot(s[:-1] + 0.5, np.diff(x), label="at first")
        axes.plot(s[:-1] + 0.5, slope, label="400 segments later")
        axes.set_xlabel("segments")
        axes.set_ylabel("slope")
        axes.legend()

    name = "chain_solitary_wave" if is_right else "chain_wave_of_the_printed_term"
    gallery(name, "A transverse pulse on a chain that moves in x alone (thesis Eq. 5.20).", draw)
    if not is_right:
        assert abs(slope.max() / start - 1.0) > 0.1
        return
    assert slope.max() == pytest.approx(start, rel=0.02)
    near = slope > 0.3 * slope.max()
    centre = float(np.average(s[:-1][near] + 0.5, weights=slope[near]))
    assert centre == pytest.approx(speed * duration, abs=0.1 * WIDTH**2 / 24.0 * duration)


def test_on_a_line_whose_tension_evens_out_the_pulse_is_no_solitary_wave():
    """The same pulse on the plant, whose nodes also move along the wire: tension stays within 0.5 % of uniform, where
    the slope of 1.4 % alone would add (1/2) EA x_s^2 = 4 %, and the pulse spreads as in the linear chain.
    """
    segments, spacing = 260, 1.0
    plant = wire(segments * spacing, segments, 0.004, stiffness=TENSION / STRAIN)
    speed = math.sqrt(TENSION / MU / (1.0 + STRAIN))
    rate = WIDTH * speed / spacing

    def motion(t):
        phase = rate * t - 8.0
        return PointMotion(
            t,
            np.array([2.0 * SLOPE / WIDTH * math.atan(math.exp(phase)) * spacing, 0.0, 0.0]),
            np.array([SLOPE / WIDTH / math.cosh(phase) * rate * spacing, 0.0, 0.0]),
        )

    tick, travelled, largest, swing = 0.02, 200.0, [], 0.0
    for step in range(round((16.0 / WIDTH + travelled) * spacing / speed / tick)):
        plant.advance(tick, motion(step * tick), motion((step + 1) * tick), 0.0, 0.0, 0.0, 0.0)
        largest.append(float(np.abs(np.diff(plant.node_positions[:, 0])).max()))
        swing = max(swing, float(np.ptp(plant.segment_tensions)))
    assert max(largest) == pytest.approx(SLOPE, rel=0.03)
    assert swing < 0.005 * TENSION
    # the chain's own linear dispersion of this pulse over the same way, by its Fourier integral
    k = np.linspace(1e-4, math.pi, 20_001)
    spectrum = 1.0 / np.cosh(0.5 * math.pi * k / WIDTH)
    times = np.linspace(-10.0, 10.0, 201) + travelled + 0.0
    linear = [
        np.trapezoid(spectrum * np.cos(k * travelled - 2.0 * np.sin(0.5 * k) * time), k) * SLOPE / WIDTH
        for time in times
    ]
    assert largest[-1] == pytest.approx(max(linear), rel=0.05)
    assert largest[-1] < 0.9 * SLOPE


@pytest.mark.parametrize("step", [0.1, 1.0, 10.0])
def test_the_plants_scheme_loses_what_generalised_alpha_loses(step):
    """Of a unit on one segment, rung by the top: the factors of the amplification matrix of Chung & Hulbert (1993).

    At 0.8 of spectral radius, omega dt = 0.1 keeps all but 7e-8 of the amplitude in a step, where Eq. 5.21 keeps 0.995.
    """
    radius, length, stiffness, mass = 0.8, 100.0, 1.5e7, 100.0
    omega = math.sqrt(stiffness / length / (mass + 0.5 * MU * length))
    dt = step / omega
    cable = CableParameters(mass_per_length=MU, axial_stiffness=stiffness, added_mass=0.0)
    unit = UnitParameters(mass=mass, volume=0.0, drag_coefficient=(0.0,) * 3, thrust=(0.0, 0.0, -TENSION))
    solver = SolverParameters(time_step=dt, spectral_radius=radius, tolerance=1e-12)
    plant = CableDynamics(
        CableSimParameters(
            length=length, segments=1, water_density=0.0, gravity=0.0, cable=cable, unit=unit, solver=solver
        )
    )
    plant.start_at_equilibrium(np.zeros(3))
    rest = plant.unit_position[2] + 1e-3
    before, after = PointMotion(0.0), PointMotion(dt, np.array([0.0, 0.0, 1e-3]), np.zeros(3))
    record = []
    for _ in range(60):
        plant.advance(dt, before, after, 0.0, 0.0, 0.0, 0.0)
        record.append(plant.unit_position[2] - rest)
        before = after
    alpha_m, alpha_f = (2.0 * radius - 1.0) / (radius + 1.0), radius / (radius + 1.0)
    gamma, beta = 0.5 - alpha_m + alpha_f, 0.25 * (1.0 - alpha_m + alpha_f) ** 2
    # (x, v dt, a dt^2): Newmark, and the balance of the blended state
    new = np.array([[1.0, 0.0, -beta], [0.0, 1.0, -gamma], [(1.0 - alpha_f) * step**2, 0.0, 1.0 - alpha_m]])
    old = np.array([[1.0, 1.0, 0.5 - beta], [0.0, 1.0, 1.0 - gamma], [-alpha_f * step**2, 0.0, -alpha_m]])
    a, b, c = np.poly(np.linalg.eigvals(np.linalg.solve(new, old)))[1:]
    x = np.array(record)
    assert x[3:] + a * x[2:-1] + b * x[1:-2] + c * x[:-3] == pytest.approx(0.0, abs=1e-5 * np.abs(x).max())
    assert np.abs(x).max() > 1e-4
    if step == 0.1:
        assert 1.0 - max(abs(np.roots([1.0, a, b, c]))) == pytest.approx(7e-8, abs=1e-8)
