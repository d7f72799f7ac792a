"""A box in the splash zone beside the simplified method of lifting analysts, by hand.

The method: DNV-RP-N103 (2017) section 4, "Lifting through wave zone - simplified method", the same in DNV-RP-H103
(2011) 4.3. With the characteristic wave zeta = 0.9 Hs and T_z, omega = 2 pi/T_z, at a depth d

    v_w = omega zeta e^{-omega^2 d/g}, a_w = omega v_w
    slamming          F_slam = (1/2) rho C_s A_s v_s^2, v_s = v_c + sqrt(v_ct^2 + v_w^2)
    varying buoyancy  F_rho = rho g dV, dV = A_w sqrt(zeta^2 + eta_ct^2)
    mass              F_M = sqrt(((M + A_33) a_ct)^2 + ((rho V + A_33) a_w)^2)
    drag              F_D = (1/2) rho C_D A_p v_r^2, v_r = v_c + sqrt(v_ct^2 + v_w^2)
    together          F_hyd = sqrt((F_D + F_slam)^2 + (F_M - F_rho)^2)

Here a still crane tip holds the box (eta_ct, v_ct, a_ct and v_c are 0) in the regular wave of that zeta and T_z. Each
force is looked at where it acts alone; the simulation takes the water's motion at the underside of the box.
"""

import math

import numpy as np
import pytest
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.parameters import CableParameters, CableSimParameters, SolverParameters
from cable_sim_node.unit_parameters import BoxParameters, UnitParameters
from heave_node.interface.waves import Waves
from heave_node.numerics.constants import STANDARD_GRAVITY
from heave_node.numerics.kinematics import PointMotion

DENSITY, MASS, VOLUME, ADDED = 1025.0, 40e3, 8.0, 48e3
LENGTH, BREADTH, HEIGHT, SLAMMING, DRAG = 5.0, 4.0, 4.0, 5.0, 2.5
AREA, WATERLINE = LENGTH * BREADTH, VOLUME / HEIGHT
ZETA, PERIOD = 0.9 * 1.5, 8.0
OMEGA = 2.0 * math.pi / PERIOD
HELD = CableParameters(
    diameter=0.004, mass_per_length=0.05, axial_stiffness=4e10, internal_damping=3.6e8, tangential_drag=0.0
)
"""Light and stiff, damped critically: the box moves by less than a tenth of a millimetre."""
TICK = 0.01


def loads(underside, *, zeta=ZETA, period=PERIOD, added=ADDED, drag=0.0, slamming=0.0, seconds=None):
    """Hold the box with its `underside` at a height [m]; return times and the water's force on it, positive up [N]."""
    box = BoxParameters(length=LENGTH, breadth=BREADTH, height=HEIGHT, slamming=slamming)
    unit = UnitParameters(
        mass=MASS, volume=VOLUME, added_mass=(added,) * 3, drag_coefficient=(drag,) * 3, drag_area=(AREA,) * 3, box=box
    )
    plant = CableDynamics(
        CableSimParameters(length=20.0, segments=2, cable=HELD, unit=unit, solver=SolverParameters(time_step=TICK))
    )
    tip = PointMotion(0.0, np.array([0.0, 0.0, 20.0 + underside]))
    plant.start_at_equilibrium(tip.position)
    omega, ramp = np.full(2, 2.0 * math.pi / period), 2.0 * period
    # two waves of half the height that meet: below the boom tip the water goes up and down only, and nothing swings
    plant.set_waves(Waves(omega, omega, np.full(2, 0.5 * zeta), np.zeros(2), np.array([0.0, math.pi]), ramp=ramp))
    times, forces = [], []
    for k in range(round((seconds or 4.0 * period) / TICK)):
        plant.advance(TICK, tip, tip, 0.0, 0.0, 0.0, 0.0)
        if k * TICK > ramp:
            times.append(plant.time)
            # M a = F - M g + T; what the line weighs is a thousandth of a newton of it
            pull = plant.segment_tensions[0]
            forces.append(MASS * (plant.unit_acceleration[2] + STANDARD_GRAVITY) - pull)
    return np.array(times), np.array(forces)


def water(underside):
    """Return the speed and the acceleration of the water [m/s], [m/s^2] at the underside, v_w and a_w of the method."""
    speed = OMEGA * ZETA * math.exp(-(OMEGA**2) / STANDARD_GRAVITY * max(-underside, 0.0))
    return speed, OMEGA * speed


def amplitude(values):
    return 0.5 * (max(values) - min(values))


def test_the_mass_force_of_a_wet_box():
    """10 m deep: (1025 x 8 + 48,000) kg x 0.444 m/s^2 = 24.9 kN."""
    by_hand = (DENSITY * VOLUME + ADDED) * water(-10.0)[1]
    assert by_hand == pytest.approx(24.95e3, rel=0.005)
    assert amplitude(loads(-10.0)[1]) == pytest.approx(by_hand, rel=0.01)


def test_the_drag_of_a_wet_box():
    """Without its inertia: (1/2) x 1025 x 2.5 x 20 x 0.566^2 = 8.2 kN at the largest speed."""
    by_hand = 0.5 * DENSITY * DRAG * AREA * water(-10.0)[0] ** 2
    assert by_hand == pytest.approx(8.2e3, rel=0.005)
    times, forces = loads(-10.0, drag=DRAG)
    inertia = loads(-10.0)[1]
    assert len(times) == len(inertia)
    assert amplitude(forces - inertia) == pytest.approx(by_hand, rel=0.01)


def test_the_varying_buoyancy_of_a_box_in_the_surface():
    """Half wet in a swell: 1025 x 9.81 x 2 m^2 x 1.35 m = 27.1 kN, less rho V a_w of what is wet at the crest."""
    slow = 40.0
    crest = 2.0 + ZETA
    acceleration = (
        (2.0 * math.pi / slow) ** 2 * ZETA * math.exp(-((2.0 * math.pi / slow) ** 2) / STANDARD_GRAVITY * 2.0)
    )
    by_hand = DENSITY * STANDARD_GRAVITY * WATERLINE * ZETA
    assert by_hand == pytest.approx(27.14e3, rel=0.005)
    forces = loads(-2.0, period=slow, added=0.0)[1]
    froude_krylov = DENSITY * WATERLINE * crest * acceleration
    rest = DENSITY * STANDARD_GRAVITY * WATERLINE * 2.0
    assert max(forces) - rest == pytest.approx(by_hand - froude_krylov, rel=0.01)


def test_the_slam_of_a_wave_that_reaches_the_underside():
    """The surface rises through z = 0 at omega zeta: (1/2) x 1025 x 5 x 20 x 1.06^2 = 57.6 kN."""
    by_hand = 0.5 * DENSITY * SLAMMING * AREA * water(0.0)[0] ** 2
    assert by_hand == pytest.approx(57.6e3, rel=0.005)
    times, forces = loads(0.0, slamming=SLAMMING)
    passed = (times % PERIOD - 0.75 * PERIOD) % PERIOD
    first = (passed > 0.015) & (passed < 0.035)
    assert first.any()
    # what has got wet by then floats a little
    buoyancy = DENSITY * STANDARD_GRAVITY * WATERLINE * water(0.0)[0] * passed[first]
    assert forces[first] - buoyancy == pytest.approx(by_hand, rel=0.01)


def test_the_method_is_above_the_simulation_of_a_held_box_whose_underside_is_at_the_surface():
    """The method adds peaks that do not come together, and takes the wet box for all of it: 1.45 times here.

    F_slam 57.6 kN, F_D 28.8 kN, F_M (with the half of V that is wet at mean, and A_33) 43.4 kN, F_rho 27.1 kN:
    together sqrt(86.4^2 + 16.3^2) = 87.9 kN.
    """
    speed, acceleration = water(0.0)
    slam = 0.5 * DENSITY * SLAMMING * AREA * speed**2
    drag = 0.5 * DENSITY * DRAG * AREA * speed**2
    mass = (DENSITY * 0.5 * VOLUME + ADDED) * acceleration
    buoyancy = DENSITY * STANDARD_GRAVITY * WATERLINE * ZETA
    method = math.hypot(drag + slam, mass - buoyancy)
    assert method == pytest.approx(87.9e3, rel=0.005)
    simulated = max(loads(0.0, drag=DRAG, slamming=SLAMMING)[1])
    assert method / simulated == pytest.approx(1.45, abs=0.02)
