"""Dispersion by bending (thesis 12.4.6), the nonlinear chain (5.3.2, Eqs. 5.18 to 5.20) and its scheme (5.4, 5.5).

No section prints a number. Eqs. 5.18 and 5.19 hold with the local T in front of the bracket, which grows by
EA x_s^2/2. Eq. 5.20 takes it as constant and so loses a third of its nonlinear term, which is 3/(2 e) x'^2 and not
(1/e) x'^2: the solitary wave is x' = A sech(k (s - V t)), (k l)^2 = 3 A^2/e, V = c (1 + (k l)^2/24).
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.parameters import CableParameters, CableSimParameters, SolverParameters, UnitParameters
from heave_node.numerics.kinematics import PointMotion
from scipy.integrate import quad

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


def force_along(slope, strain):
    """Return the force along x of a segment with a `slope`, over EA: (1 - 1/r) x_s, r^2 = (1 + e)^2 + x_s^2."""
    return (1.0 - 1.0 / np.hypot(1.0 + strain, slope)) * slope


@pytest.mark.parametrize("strain", [0.003, 0.01])
def test_equations_5_18_and_5_19_hold_with_the_local_tension_in_front(strain):
    """Beside the derivative of the exact force by the slope, to the first order of a strain of up to 1.5 e."""
    slope = np.linspace(0.0, math.sqrt(strain), 11)
    exact = (force_along(slope + 1e-6, strain) - force_along(slope - 1e-6, strain)) / 2e-6
    local = np.hypot(1.0 + strain, slope) - 1.0
    assert local * (1.0 + slope**2 / local) == pytest.approx(exact, rel=3.0 * strain)
    constant = strain * (1.0 + slope**2 / strain)
    assert constant[-1] < 0.9 * exact[-1]


@pytest.mark.parametrize(("term", "is_right"), [(1.5, True), (1.0, False)])
def test_the_period_of_a_chain_of_one_mass_has_the_nonlinear_term_3_over_2_e(term, is_right):
    """Thesis Eq. 5.20: of a mass between two segments the period is the integral of dx/v by energy, at e = 1 %.

    x'' ~ x + b x^3 with 3 b = 3/(2 e (1 + e)^2), or the printed 1/e, moves by 3 b a^2/8: 0.000460 or 0.000313 at 0.005.
    """
    e, a = 0.01, 0.005

    def inverse_speed(angle):
        # U(a) - U(x) = (a^2 - x^2) (1/2 - 1/(r(a) + r(x))), x = a sin(angle)
        lengths = math.hypot(1.0 + e, a) + math.hypot(1.0 + e, a * math.sin(angle))
        return 1.0 / math.sqrt(1.0 - 2.0 / lengths)

    quarter = quad(inverse_speed, 0.0, 0.5 * math.pi, epsabs=1e-12)[0]
    exact = 0.5 * math.pi / quarter / math.sqrt(e / (1.0 + e)) - 1.0
    shift = 0.125 * term / (e * ((1.0 + e) ** 2 if is_right else 1.0)) * a**2
    assert exact == pytest.approx(4.61e-4, abs=2e-6)
    assert (abs(shift / exact - 1.0) < 0.01) is is_right


def printed_step(state, ends, lengths, stiffness, mass, dt, squares):
    """Return the next (now, before) of a mass between held ends by thesis Eq. 5.21: implicit in T, not in direction.

    (T'/EA + 1) l^2 (T/EA + 1) = d' d of section 5.4 gives T', with `squares` in the place of the two l^2.
    """
    now, before = state
    matrix, right = np.eye(2), 2.0 * now - before
    for end, length, square in zip(ends, lengths, squares, strict=True):
        d = end - now
        size = np.linalg.norm(d)
        gain = stiffness * length / (square * size)
        matrix = matrix + dt**2 / mass * np.outer(d / size, gain * d)
        right = right + dt**2 / mass * (gain * (d @ end) - stiffness) * d / size
    return np.array([np.linalg.solve(matrix, right), now])


def growth(axis, dt, lengths=(1.0, 1.0), strain=0.01):
    """Return the amplification factors per step by Eq. 5.21 of a disturbance along an axis, EA 1, mass 1."""
    lengths = np.array(lengths)
    ends = (np.array([-lengths[0] * (1.0 + strain), 0.0]), np.array([lengths[1] * (1.0 + strain), 0.0]))
    rows = []
    for which in range(2):
        moved = []
        for sign in (1.0, -1.0):
            state = np.zeros((2, 2))
            state[which, axis] = sign * 1e-6
            moved.append(printed_step(state, ends, lengths, 1.0, 1.0, dt, lengths**2)[:, axis])
        rows.append((moved[0] - moved[1]) / 2e-6)
    return np.linalg.eigvals(np.array(rows).T)


def test_the_second_tension_of_section_5_4_belongs_to_its_own_length():
    """With l_{i-1/2} a mass at rest between a short and a long segment stays; with the printed l_{i+1/2} it moves."""
    lengths = np.array([0.6, 1.4])
    ends = (np.array([-0.6 * 1.01, 0.0]), np.array([1.4 * 1.01, 0.0]))
    for squares, is_right in ((lengths**2, True), (np.full(2, 1.4**2), False)):
        now, _ = printed_step(np.zeros((2, 2)), ends, lengths, 1.0, 1.0, 0.1, squares)
        assert bool(np.abs(now).max() < 1e-12) is is_right


@pytest.mark.parametrize("step", [0.1, 1.0, 10.0])
def test_equation_5_21_damps_along_the_cable_as_printed_and_is_not_stable_across(step):
    """Thesis 5.5: along, (1 +- i sqrt(q))/(1 + q) with q = (omega dt)^2; it omits the change of direction, Delta B.

    With it, waves across are those of the explicit scheme: without decay up to omega dt = 2, without bounds above.
    """
    root = math.sqrt(2.0)
    printed = np.array([1.0 - 1j * step, 1.0 + 1j * step]) / (1.0 + step**2)
    assert np.sort_complex(growth(0, step / root)) == pytest.approx(printed, abs=1e-5)
    across = np.abs(growth(1, step / math.sqrt(2.0 * 0.01 / 1.01)))
    expected = (step**2 - 2.0 + step * math.sqrt(step**2 - 4.0)) / 2.0 if step > 2.0 else 1.0
    assert across.max() == pytest.approx(expected, rel=1e-3)


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
