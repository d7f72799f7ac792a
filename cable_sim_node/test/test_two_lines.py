"""Two lines to one unit: at rest as the network of `heave static`; two equal ones as one that is twice as strong."""

import copy
import math
from dataclasses import replace

import numpy as np
import pytest
from cable_sim_node.component import CableSim
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.line.two_lines import TwoLines
from cable_sim_node.node_parameters import CableSimNodeParameters
from cable_sim_node.parameters import CableParameters, CableSimParameters, SecondLineParameters
from cable_sim_node.physics.current import Current
from heave_node.numerics.kinematics import PointMotion
from heave_statics.network import NetworkCable, NetworkPoint, solve_network
from heave_statics.suspended import suspended_cable, unit_load
from heave_statics.system import PointLoad

from tests.validation.peers.driven_run import first_harmonic, ramped_sine

UMBILICAL = SecondLineParameters(length=330.0, at=(-30.0, 8.0, 0.0))
PLANT = CableSimParameters(segments=40, current=(0.3, 0.1), second_line=replace(UMBILICAL, segments=40), surface=False)


@pytest.mark.parametrize("length", [330.0, 303.0, 301.2])
def test_at_rest_they_are_the_network_of_statics(length):
    """A slack umbilical, one that is nearly taut, and one that takes a part of the load; both codes to their meshes."""
    plant = replace(PLANT, second_line=replace(PLANT.second_line, length=length))
    lines = TwoLines(plant)
    lines.start_at_equilibrium(np.zeros(3))
    ropes = [suspended_cable(one, PointLoad(0.0)) for one in (plant, lines.second.parameters)]
    points = {"tip": NetworkPoint((0.0, 0.0, 0.0)), "stern": NetworkPoint(plant.second_line.at)}
    points["unit"] = NetworkPoint(None, unit_load(plant))
    cables = [NetworkCable("unit", end, rope) for end, rope in zip(("tip", "stern"), ropes, strict=True)]
    found = solve_network(points, cables, Current((0.3, 0.1)))
    assert lines.unit_position == pytest.approx(found.places["unit"], abs=0.02)
    assert lines.second_pull == pytest.approx(-found.shapes[1].start_force, rel=0.01, abs=15.0)
    assert lines.top_tension == pytest.approx(found.shapes[0].top_tension, rel=2e-3)


def test_it_stays_at_rest():
    lines = TwoLines(PLANT)
    lines.start_at_equilibrium(np.zeros(3))
    before, still = lines.unit_position, PointMotion()
    for _ in range(400):
        lines.advance(0.05, still, still, 0.0, 0.0, 0.0, 0.0)
    assert lines.unit_position == pytest.approx(before, abs=1e-4)
    assert lines.second.unit_position == pytest.approx(lines.unit_position, abs=1e-9)


@pytest.mark.parametrize(("period", "accepted"), [(8.0, 2e-3), (4.0, 5e-3)])
def test_two_equal_lines_are_one_of_twice_the_stiffness_mass_weight_and_drag(period, accepted):
    """1 m at the boom tip. The unit and half of the doubled line's end are the same; the resonance is at 1.7 s."""
    single = CableParameters(displaced_diameter=0.03, tangential_drag=0.01)
    double = replace(
        single,
        diameter=2.0 * single.diameter,
        displaced_diameter=0.03 * math.sqrt(2.0),
        mass_per_length=2.0 * single.mass_per_length,
        axial_stiffness=2.0 * single.axial_stiffness,
    )
    own = {"diameter": single.diameter, "mass_per_length": 5.4, "axial_stiffness": single.axial_stiffness}
    beside = SecondLineParameters(length=300.0, at=(0.0, 0.0, 0.0), **own)
    plain = CableSimParameters(surface=False)
    plants = [TwoLines(replace(plain, cable=replace(single, displaced_diameter=0.0), second_line=beside))]
    plants.append(CableDynamics(replace(plain, cable=replace(double, displaced_diameter=0.047 * math.sqrt(2.0)))))
    omega, found = 2.0 * math.pi / period, []
    motion = ramped_sine((0.0, 0.0, 1.0), omega, 2.0 * period)
    for plant in plants:
        plant.start_at_equilibrium(np.zeros(3))
        times, heave = 0.05 * np.arange(1, round(14.0 * period / 0.05)), []
        for t in times:
            plant.advance(0.05, motion(t - 0.05), motion(t), 0.0, 0.0, 0.0, 0.0)
            heave.append(plant.unit_position[2])
        late = times > 8.0 * period
        found.append(first_harmonic(times[late], np.array(heave)[late], omega))
    (mean, size, phase), (mean_one, size_one, phase_one) = found
    assert size == pytest.approx(size_one, rel=accepted)
    assert phase == pytest.approx(phase_one, abs=accepted)
    assert mean == pytest.approx(mean_one, abs=2e-3)


def test_an_umbilical_that_is_paid_too_short_holds_the_unit_back_while_it_is_lowered():
    """The lift line pays out 5 m; the umbilical, 301.2 m to a point 31 m away, does not: the unit hangs on both."""
    plant = replace(PLANT, second_line=replace(PLANT.second_line, length=301.2), current=(0.0, 0.0))
    lines, still = TwoLines(plant), PointMotion()
    lines.start_at_equilibrium(np.zeros(3))
    before = np.linalg.norm(lines.second_pull)
    for k in range(600):
        paid = [min(0.2 * 0.05 * (k + end), 5.0) for end in (0, 1)]
        lines.advance(
            0.05, still, still, paid[0], 0.2 if paid[0] < 5.0 else 0.0, paid[1], 0.2 if paid[1] < 5.0 else 0.0
        )
    assert np.linalg.norm(lines.second_pull) > 2.0 * before
    assert float(lines.second.top_tension) + lines.top_tension > 0.9 * plant.unit.weight_in_fluid(1025.0)


def test_two_lines_in_the_plant_have_a_shadow_of_their_own():
    given = CableSimNodeParameters(second_line=UMBILICAL, segments=10)
    plant = CableSim(given, seed=1, tick_period=0.05)
    for tick in range(1, 20):
        height = 0.05 * (1.0 - math.cos(0.3 * tick))
        motion = PointMotion(
            0.05 * (tick + 1), np.array([0.0, 0.0, height]), np.array([0.0, 0.0, 0.3 * math.sin(0.3 * tick)])
        )
        plant.advance(tick, motion, (height, motion.velocity[2]))
    state = plant.state()
    assert abs(state.unit.position[2] - state.uncompensated.position[2]) > 1e-3
    one = copy.deepcopy(plant)
    assert one.state().top_tension == state.top_tension
