"""Chapter 3 of the thesis with the axial model: five examples by their printed particulars.

The measured curves of the figures are not printed as numbers. What is checked: the numbers in the text, exact linear
theory where the cable stays taut, and each observation the text makes.
"""

import dataclasses
import math

import numpy as np
import pytest
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.parameters import CableParameters, CableSimParameters, UnitParameters
from cable_sim_node.vertical.axial import simulate_axial
from cable_sim_node.vertical.axial_line import AxialLine, AxialSection, AxialUnit, axial_line
from cable_sim_node.vertical.linear import heave_transfer_function, natural_frequencies, resonant_length
from heave_node.numerics.constants import SEAWATER_DENSITY, STANDARD_GRAVITY
from heave_node.numerics.kinematics import PointMotion


def area(diameter):
    return 0.25 * math.pi * diameter**2


def regular_run(line, length, omega, amplitude, cycles=60):
    """Drive the boom tip by a ramped sine; return static tension, and largest and least tension of the last cycles."""
    period = 2.0 * math.pi / omega
    time = np.arange(0.0, cycles * period, period / 40.0)
    share = np.clip(3.0 * time / time[-1], 0.0, 1.0)
    heave = amplitude * 0.5 * (1.0 - np.cos(np.pi * share)) * np.sin(omega * time)
    response = simulate_axial(line, length, heave, period / 40.0, segments=10, largest_step=period / 400.0)
    late = time > 0.9 * time[-1]
    return (
        line.static_top_tension(length),
        float(response.top_tension[late].max()),
        float(response.least_tension[late].min()),
    )


# examples one and two: polyester ropes with a wooden sphere in air
SPHERE = AxialUnit(4.722, 4.722 * STANDARD_GRAVITY)
ROPE_LENGTH = 4.573
EXAMPLE_ONE = AxialLine((AxialSection(math.inf, 3.38e9 * area(0.003), 8.067e-3, 8.067e-3 * STANDARD_GRAVITY),), SPHERE)
EXAMPLE_TWO = AxialLine((AxialSection(math.inf, 2.445e9 * area(0.002), 4.155e-3, 4.155e-3 * STANDARD_GRAVITY),), SPHERE)


@pytest.mark.parametrize(("line", "amplitude"), [(EXAMPLE_ONE, 0.05), (EXAMPLE_TWO, 0.1)], ids=["one", "two"])
def test_examples_one_and_two_largest_tension_in_air(line, amplitude):
    frequencies = np.arange(0.4, 3.01, 0.2)
    omegas = 2.0 * np.pi * frequencies
    runs = [regular_run(line, ROPE_LENGTH, omega, amplitude) for omega in omegas]
    linear = heave_transfer_function(line, ROPE_LENGTH, omegas)
    theory = line.static_top_tension(ROPE_LENGTH) + amplitude * np.abs(linear.top_tension)

    taut = [(run, expected) for run, expected in zip(runs, theory, strict=True) if run[2] > 0.0]
    assert len(taut) >= 4
    for (_, largest, _), expected in taut:
        assert largest == pytest.approx(expected, rel=5e-3)
    # the thesis: at higher frequency the rope goes slack and snatches; beyond that linear theory underrates the tension
    slack = [(run, expected) for run, expected in zip(runs, theory, strict=True) if run[2] == 0.0]
    assert slack
    assert slack[0][0][1] > 1.2 * slack[0][1]
    # linear theory itself says where: the sphere's acceleration passes gravity
    first = next(i for i, run in enumerate(runs) if run[2] == 0.0)
    acceleration = amplitude * np.abs(linear.unit_heave) * omegas**2
    assert acceleration[first - 1] < STANDARD_GRAVITY
    assert acceleration[first] > 0.9 * STANDARD_GRAVITY


# examples three and four: nylon rope with an aluminium sphere, in air and in fresh water (its weight there is printed)
NYLON = {"length": math.inf, "axial_stiffness": 2.67e8 * area(0.00635), "mass": 3.23e-2}
NYLON_LENGTH = 22.25
IN_AIR = AxialLine(
    (AxialSection(**NYLON, weight=3.23e-2 * STANDARD_GRAVITY),), AxialUnit(12.65, 12.65 * STANDARD_GRAVITY)
)
IN_WATER = AxialLine(
    (
        AxialSection(
            **NYLON,
            weight=(3.23e-2 - 1000.0 * area(0.00635)) * STANDARD_GRAVITY,
            drag=0.5 * math.pi * 1000.0 * 0.01 * 0.00635,
        ),
    ),
    AxialUnit(12.65 + 2.3, 83.68, 0.5 * 1000.0 * 0.5 * area(0.2032)),
)
SPRING = 2.67e8 * area(0.00635) / NYLON_LENGTH
RATIOS = np.array([0.3, 0.5, 0.7, 0.85, 0.95, 1.0, 1.05, 1.2, 1.5, 2.0])


def test_example_three_has_the_printed_spring_constant():
    assert pytest.approx(380.0, rel=1e-3) == SPRING


def test_example_three_weight_in_water_is_that_of_the_printed_sphere():
    sphere = 1000.0 * math.pi / 6.0 * 0.2032**3
    # printed 83.68 N; the sphere's own volume gives 81.0 N (its fittings are not described)
    assert (12.65 - sphere) * STANDARD_GRAVITY == pytest.approx(83.68, rel=0.04)


def test_resonance_in_air_and_water_is_where_spring_and_mass_put_it():
    # the rope's mass counts by a third; printed "measured" 1.1 and 0.72 Hz belong to the experiments' stiffness, not to
    # the printed particulars, which give 0.86 and 0.80 Hz
    for line, mass in ((IN_AIR, 12.65), (IN_WATER, 12.65 + 2.3)):
        expected = math.sqrt(SPRING / (mass + 3.23e-2 * NYLON_LENGTH / 3.0)) / (2.0 * math.pi)
        found = natural_frequencies(line, NYLON_LENGTH, 1)[0] / (2.0 * math.pi)
        assert found == pytest.approx(expected, rel=1e-4)


def nondimensional_tension(line, amplitude):
    """(Tmax - Tstatic)/(K x0) at `RATIOS` of the resonance, and whether the rope stayed taut."""
    omegas = RATIOS * natural_frequencies(line, NYLON_LENGTH, 1)[0]
    runs = [regular_run(line, NYLON_LENGTH, omega, amplitude, cycles=150) for omega in omegas]
    values = np.array([(largest - static) / (SPRING * amplitude) for static, largest, _ in runs])
    return omegas, values, np.array([least > 0.0 for _, _, least in runs])


def test_examples_three_and_four_nondimensional_tension():
    cases = {
        "in air, 25.4 mm": (IN_AIR, 0.0254),
        "in water, 25.4 mm": (IN_WATER, 0.0254),
        "in water, 50.8 mm": (IN_WATER, 0.0508),
    }
    found = {name: nondimensional_tension(*case) for name, case in cases.items()}

    for name, (line, amplitude) in cases.items():
        omegas, values, taut = found[name]
        linear = heave_transfer_function(line, NYLON_LENGTH, omegas, amplitude=amplitude if line is IN_WATER else 0.0)
        compared = taut & (np.abs(RATIOS - 1.0) > (0.0 if line is IN_WATER else 0.1))
        assert compared.sum() >= 6
        assert values[compared] == pytest.approx(np.abs(linear.top_tension[compared]) / SPRING, rel=0.03)
    at_resonance = int(np.argmin(np.abs(RATIOS - 1.0)))
    air, small, large = (found[name][1][at_resonance] for name in cases)
    # thesis 3.3.4: water reduces the ratio near resonance, and more so the larger the excitation
    assert large < small < air
    # far from resonance neither matters
    assert found["in water, 25.4 mm"][1][0] == pytest.approx(found["in water, 50.8 mm"][1][0], rel=5e-3)


# example five: deployment from 50 m. Weight, drag and heave amplitude are not printed: drag as for S900 (C_D S = 1 m2,
# C_tau 0.025), the unit's weight in water that of 5000 kg of steel; heave 1 m as in the figures of chapter 6.
DEPLOYED = AxialLine(
    (
        AxialSection(
            math.inf,
            9.05e9 * area(0.047),
            7.2,
            (7.2 - SEAWATER_DENSITY * area(0.047)) * STANDARD_GRAVITY,
            0.5 * math.pi * SEAWATER_DENSITY * 0.025 * 0.047,
        ),
    ),
    AxialUnit(13000.0, 0.87 * 5000.0 * STANDARD_GRAVITY, 0.5 * SEAWATER_DENSITY),
)


def without_drag(line):
    sections = tuple(dataclasses.replace(section, drag=0.0) for section in line.sections)
    return AxialLine(sections, dataclasses.replace(line.unit, drag=0.0))


SPEEDS = (0.5, 1.0, 2.0, 3.0)
FREQUENCIES = (0.4189, 0.628, 0.838, 1.26)


def deploy(speed, omega, amplitude=1.0, furthest=2000.0, line=DEPLOYED):
    """Lower from 50 m; return length out, amplitude and mean of the unit's heave over each period, least tension."""
    period = 0.1
    time = np.arange(0.0, min(2000.0, furthest / speed), period)
    heave = amplitude * np.clip(time / 20.0, 0.0, 1.0) * np.sin(omega * time)
    response = simulate_axial(line, 50.0, heave, period, payout=speed * time, segments=20, largest_step=0.02)
    motion = response.unit_heave + speed * time
    window = round(2.0 * math.pi / omega / period)
    kernel = np.ones(window) / window
    mean = np.convolve(motion, kernel, "same")
    size = np.sqrt(2.0 * np.convolve((motion - mean) ** 2, kernel, "same"))
    inner = slice(2 * window, -2 * window)
    return 50.0 + speed * time[inner], size[inner], mean[inner], response.least_tension[inner]


@pytest.fixture(scope="module")
def deployments():
    return {(speed, omega): deploy(speed, omega) for speed in SPEEDS for omega in FREQUENCIES}


def test_example_five_sixteen_deployments(deployments):

    for (speed, omega), (length, size, _, least) in deployments.items():
        assert np.all(np.isfinite(size)), (speed, omega)
        assert np.all(least >= 0.0)
        # while the cable is short the answer is nearly that of a constant length
        early = int(np.argmin(np.abs(length - 100.0 - 25.0 * speed)))
        steady = heave_transfer_function(DEPLOYED, float(length[early]), [omega], amplitude=1.0).unit_heave[0]
        assert size[early] == pytest.approx(abs(steady), rel=0.1), (speed, omega)


def test_a_higher_speed_passes_resonance_with_less_motion(deployments):
    # observation 1, where all four speeds pass the resonance
    largest = [deployments[speed, 1.26][1].max() for speed in SPEEDS]
    assert np.all(np.diff(largest) < 0.0)
    passed = [deployments[speed, 0.838][1].max() for speed in SPEEDS[1:]]
    assert np.all(np.diff(passed) < 0.0)


def test_drag_lifts_the_deployed_unit_but_less_than_its_stretch(deployments):
    # observation 2: compression grows with speed and length, and stays below the static elongation
    lifts = []
    for speed in SPEEDS:
        length, _, mean, _ = deployments[speed, 0.628]
        # `mean` is counted from the static place at 50 m
        stretch = np.array([DEPLOYED.static_stretch(float(out)) for out in length[::100]])
        lift = mean[::100] + stretch - stretch[0]
        near = int(np.argmin(np.abs(length[::100] - 1000.0)))
        assert 0.0 < lift[near] < stretch[near]
        lifts.append(lift[near])
    assert np.all(np.diff(lifts) > 0.0)


def test_the_critical_length_grows_with_the_speed_of_deployment():
    # observation 3: the length has passed on before the motion has grown. Shown without drag in small waves; drag at
    # the lowering speed damps the resonance and brings its peak forward, and with C_D S = 1 m2 that is the stronger
    # effect at 0.838 rad/s and below (the thesis does not print its drag)
    critical = []
    for speed in SPEEDS:
        length, size, _, _ = deploy(speed, 1.26, amplitude=0.01, furthest=1500.0, line=without_drag(DEPLOYED))
        critical.append(length[int(np.argmax(size))])
    assert np.all(np.diff(critical) > 10.0)


def test_slow_deployment_is_critical_at_the_resonant_length():
    # observation 5: L = EA/(w^2 (M + Ma)) when the speed is low; small waves, so that drag and slack stay out
    omega = 1.26
    length, size, _, _ = deploy(0.5, omega, amplitude=0.01, furthest=900.0)
    critical = length[int(np.argmax(size))]
    lengths = np.linspace(300.0, 900.0, 601)
    first = np.array([natural_frequencies(DEPLOYED, float(out), 1)[0] for out in lengths])
    exact = float(np.interp(-omega, -first, lengths))
    # a little later, for the length has passed on before the motion has grown
    assert exact <= critical < 1.05 * exact
    # the rough formula leaves out the cable's own mass, here 4.5 t of 17.5: it is an upper bound, 15 % high
    assert exact < resonant_length(DEPLOYED, omega) < 1.2 * exact


def test_the_excitation_frequency_counts_by_where_resonance_is(deployments):
    # observation 4. Resonance lies beyond 2000 m at 0.4189 and 0.628 rad/s and near 600 m at 1.26 rad/s
    for speed in SPEEDS[2:]:
        sizes = {}
        for omega in FREQUENCIES:
            length, size, _, _ = deployments[speed, omega]
            sizes[omega] = np.interp((700.0, 1800.0), length, size)
        assert sizes[0.4189][0] < sizes[0.628][0] < sizes[0.838][0], speed
        # past its resonance by more than sqrt(2) the unit moves less than the boom tip, whose amplitude is 1 m
        assert sizes[1.26][1] < 1.0 < sizes[1.26][0], speed
        assert sizes[1.26][1] < sizes[0.4189][1], speed


@pytest.mark.parametrize(("speed", "omega", "goes_slack"), [(1.0, 1.26, True), (3.0, 0.838, False)])
def test_two_of_the_sixteen_agree_with_the_three_dimensional_solver(speed, omega, goes_slack):
    # `DEPLOYED` in the words of the three-dimensional solver, from 50 m to 800 m, heave 0.5 m; both start gently. At
    # 1.26 rad/s resonance near 600 m throws the cable slack.
    diameter = 0.047
    parameters = CableSimParameters(
        length=50.0,
        segments=4,
        cable=CableParameters(
            diameter=diameter, mass_per_length=7.2, axial_stiffness=9.05e9 * area(diameter), tangential_drag=0.025
        ),
        unit=UnitParameters(
            mass=5000.0,
            volume=0.13 * 5000.0 / SEAWATER_DENSITY,
            added_mass=(8000.0,) * 3,
            drag_coefficient=(1.0,) * 3,
            drag_area=(1.0,) * 3,
        ),
    )
    assert axial_line(parameters).static_top_tension(800.0) == pytest.approx(DEPLOYED.static_top_tension(800.0))
    period = 0.05
    time = np.arange(0.0, 750.0 / speed, period)
    share = np.clip(time / 20.0, 0.0, 1.0)
    rise = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    heave = 0.5 * rise * np.sin(omega * time)
    # the integral of `rise` is 20 s (2.5 s^4 - 3 s^5 + s^6), and time - 10 s after the ramp
    payout = speed * (20.0 * (2.5 * share**4 - 3.0 * share**5 + share**6) + np.clip(time - 20.0, 0.0, None))
    axial = simulate_axial(DEPLOYED, 50.0, heave, period, payout=payout, segments=40, largest_step=0.02)
    cable = CableDynamics(parameters)
    cable.start_at_equilibrium(np.zeros(3))
    heave_rate, feed = np.gradient(heave, period), speed * rise
    motions = [
        PointMotion(t, np.array([0.0, 0.0, z]), np.array([0.0, 0.0, v]))
        for t, z, v in zip(time, heave, heave_rate, strict=True)
    ]
    start, unit, tension = cable.unit_position[2], [0.0], [cable.top_tension]
    for k in range(len(time) - 1):
        cable.advance(period, motions[k], motions[k + 1], payout[k], feed[k], payout[k + 1], feed[k + 1])
        unit.append(cable.unit_position[2] - start)
        tension.append(cable.top_tension)
    swing = np.ptp(axial.unit_heave + payout)
    apart = np.abs(np.array(unit) - axial.unit_heave).max()
    assert (axial.least_tension.min() == 0.0) == goes_slack
    if goes_slack:
        # each snap depends on the mesh a little; the motion stays together
        assert apart < 0.04 * swing
    else:
        assert apart < 2e-4 * swing
        assert np.array(tension) == pytest.approx(axial.top_tension, abs=2e-3 * np.ptp(axial.top_tension))


def test_sudden_stop_gives_the_wave_tension_and_then_a_steady_motion():
    # thesis fig. 3.24. Before the wave comes back, a top end stopped from speed v feels sqrt(EA m) v more tension; the
    # end is stopped in 0.02 s, the wave needs 2 L/c = 0.54 s. The cable has no drag here: losing it would add to that.
    speed, period, stop = 1.0, 0.01, 5.0
    time = np.arange(0.0, 60.0, period)
    braking = np.clip((time - stop) / 0.02, 0.0, 1.0)
    payout = speed * np.cumsum(1.0 - braking) * period
    section = dataclasses.replace(DEPLOYED.sections[0], drag=0.0)
    line = AxialLine((section,), DEPLOYED.unit)
    response = simulate_axial(line, 400.0, np.zeros_like(time), period, payout=payout, segments=200, largest_step=0.002)

    impedance = math.sqrt(section.axial_stiffness * section.mass)
    before = response.top_tension[(time > 4.0) & (time < 4.9)].mean()
    plateau = response.top_tension[(time > 5.1) & (time < 5.4)].mean()
    assert plateau - before == pytest.approx(impedance * speed, rel=0.01)
    # then the unit swings at the resonance of 405 m and settles
    omega = natural_frequencies(line, 405.0, 1)[0]
    swing = response.unit_heave + payout
    early, late = swing[(time > 5.0) & (time < 15.0)], swing[time > 50.0]
    assert np.ptp(early) == pytest.approx(2.0 * speed / omega, rel=0.2)
    assert np.ptp(late) < 0.7 * np.ptp(early)  # by quadratic drag of the unit, slower and slower
    settling = swing[time > 10.0] - swing[time > 10.0].mean()
    crossings = np.nonzero((settling[:-1] < 0.0) & (settling[1:] >= 0.0))[0]
    swing_period = np.mean(np.diff(crossings)) * period
    assert swing_period == pytest.approx(2.0 * math.pi / omega, rel=0.02)


def test_a_quadratic_and_a_periodic_length_agree_with_a_rigid_cable_where_it_is_stiff():
    # thesis 3.1: L0 + v t + a t^2/2 and L0 + p sin(w t); with a stiff cable and no drag the unit's motion is the
    # length's, and tension is weight and inertia of all that moves
    stiff = AxialLine((AxialSection(math.inf, 1e10, 7.2, 50.0),), AxialUnit(13000.0, 4e4))
    time = np.arange(0.0, 40.0, 0.05)
    for payout, acceleration in (
        (0.5 * time + 0.5 * 0.05 * time**2, np.full_like(time, 0.05)),
        (3.0 * np.sin(0.6 * time), -3.0 * 0.36 * np.sin(0.6 * time)),
    ):
        response = simulate_axial(stiff, 100.0, np.zeros_like(time), 0.05, payout=payout)
        assert response.unit_heave == pytest.approx(-payout, abs=5e-3)
        length = 100.0 + payout
        tension = 4e4 + 50.0 * length - (13000.0 + 7.2 * length) * acceleration
        late = time > 10.0
        assert response.top_tension[late].mean() == pytest.approx(tension[late].mean(), rel=2e-3)
        smooth = np.convolve(response.top_tension - tension, np.ones(40) / 40.0, "same")[late][:-40]
        assert np.abs(smooth).max() < 0.01 * 4e4
