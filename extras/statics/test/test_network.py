"""Networks of cables: against a V by hand, the single catenary, differences, symmetry; and their file."""

import itertools
import json
import math

import numpy as np
import pytest
from cable_sim_node.errors import NoEquilibriumError, StaticsError
from cable_sim_node.parameters import CableSimParameters
from cable_sim_node.physics.current import Current, current_of
from heave_bringup.cli import main
from heave_node.parameters import ParameterError
from heave_statics.network import NetworkCable, NetworkPoint, end_stiffness, solve_network
from heave_statics.problems import submerged_cable, towing_cable
from heave_statics.reports.network import network_report
from heave_statics.suspended import shape_at_rest
from heave_statics.system import PointLoad, StaticSection, static_cable
from scipy.optimize import brentq

EA, WEIGHT, NORMAL, TANGENTIAL = 1e7, 25.0, 30.0, 1.0


def cable(length, *, stiffness=EA, weight=WEIGHT, drag=True, segments=30):
    drags = (NORMAL, TANGENTIAL) if drag else ()
    return static_cable([StaticSection(length, stiffness, weight, *drags)], segments=segments)


def load(*force, drag=0.0):
    return NetworkPoint(None, PointLoad(0.0, force, body_drag=drag))


V = {"port": NetworkPoint((0.0, 60.0, 0.0)), "starboard": NetworkPoint((0.0, -60.0, 0.0)), "unit": load(0.0, 0.0, -2e4)}


def test_a_symmetric_v_is_that_by_hand():
    """T = W/(2 sin a), L (1 + T/EA) = sqrt(60^2 + y^2), of cables that weigh 0.1 N."""
    light = cable(100.0, stiffness=1e6, weight=1e-3)
    found = solve_network(V, [NetworkCable("unit", end, light) for end in ("port", "starboard")])

    def tension(y):
        return 1e4 * math.hypot(60.0, y) / y

    depth = brentq(lambda y: 100.0 * (1.0 + tension(y) / 1e6) - math.hypot(60.0, y), 1.0, 200.0)
    assert found.places["unit"] == pytest.approx([0.0, 0.0, -depth], abs=1e-3)
    for shape in found.shapes:
        assert shape.top_tension == pytest.approx(tension(depth), rel=1e-5)


@pytest.mark.parametrize("current", [Current(), Current((0.6, 0.3)), Current([(1.0, 0.0), (0.1, 0.5)], [0.0, 80.0])])
def test_a_cable_cut_into_three_is_the_single_one(current):
    ends = {"a": NetworkPoint((0.0, 0.0, 0.0)), "b": NetworkPoint((100.0, 20.0, -30.0))}
    joints = {"one": load(0.0, 0.0, 0.0), "two": load(0.0, 0.0, 0.0)}
    names = ("a", "one", "two", "b")
    parts = [NetworkCable(*pair, cable(50.0, segments=20)) for pair in itertools.pairwise(names)]
    found = solve_network({**ends, **joints}, parts, current)
    whole = submerged_cable(cable(150.0, segments=60), (0.0, 0.0, 0.0), (100.0, 20.0, -30.0), current)
    assert found.places["one"] == pytest.approx(whole.positions[20], abs=1e-5)
    assert found.places["two"] == pytest.approx(whole.positions[40], abs=1e-5)
    assert found.shapes[0].start_force == pytest.approx(whole.start_force, rel=1e-6, abs=1e-3)


def test_the_stiffness_of_the_ends_is_that_by_differences():
    current, ends = Current([(1.0, 0.2), (0.1, 0.5)], [0.0, 80.0]), np.array([0.0, 0.0, 0.0, 70.0, 20.0, -30.0])

    def forces(at):
        shape = submerged_cable(cable(90.0), at[:3], at[3:], current)
        return np.concatenate((shape.start_force, shape.end_force))

    step = 1e-4
    slopes = np.column_stack([(forces(ends + h) - forces(ends - h)) / (2.0 * step) for h in step * np.eye(6)])
    exact = end_stiffness(submerged_cable(cable(90.0), ends[:3], ends[3:], current))
    assert exact == pytest.approx(slopes, abs=1e-5 * np.abs(slopes).max())


def test_a_load_on_one_cable_is_the_towed_one():
    current = Current((0.8, 0.2))
    found = solve_network(
        {"tip": NetworkPoint((0.0, 0.0, 0.0)), "unit": load(0.0, 0.0, -8e3, drag=400.0)},
        [NetworkCable("unit", "tip", cable(200.0, segments=60))],
        current,
    )
    hung = static_cable(
        [StaticSection(200.0, EA, WEIGHT, NORMAL, TANGENTIAL)],
        [PointLoad(0.0, (0.0, 0.0, -8e3), body_drag=400.0)],
        segments=60,
    )
    assert found.places["unit"] == pytest.approx(towing_cable(hung, (0.0, 0.0, 0.0), current).positions[0], abs=1e-5)


@pytest.mark.parametrize("current", [Current(), Current((0.7, -0.4))])
def test_a_net_with_loops_is_in_balance_and_turns_with_the_world(current):
    """Four corners held, a square of four knots between them: forces on each knot vanish; a quarter turn turns all."""

    def solved(turn):
        c, s = math.cos(turn), math.sin(turn)
        ways = [turn + 0.5 * math.pi * k for k in range(4)]
        points = {f"held{k}": NetworkPoint((40.0 * math.cos(a), 40.0 * math.sin(a), 0.0)) for k, a in enumerate(ways)}
        knots = {f"knot{k}": load(0.0, 0.0, -200.0 * (k + 1)) for k in range(4)}
        ropes = [NetworkCable(f"knot{k}", f"held{k}", cable(35.0, segments=8)) for k in range(4)]
        ropes += [NetworkCable(f"knot{k}", f"knot{(k + 1) % 4}", cable(20.0, segments=8)) for k in range(4)]
        flow = current.profile[0, 1:3]
        return solve_network(points | knots, ropes, Current((c * flow[0] - s * flow[1], s * flow[0] + c * flow[1])))

    found, turned = solved(0.0), solved(0.5 * math.pi)
    for k in range(4):
        x, y, z = found.places[f"knot{k}"]
        assert turned.places[f"knot{k}"] == pytest.approx([-y, x, z], abs=1e-6)
        hold = found.shapes[k].start_force + found.shapes[4 + k].start_force + found.shapes[4 + (k - 1) % 4].end_force
        assert hold == pytest.approx([0.0, 0.0, -200.0 * (k + 1)], abs=1e-3)


@pytest.mark.parametrize(
    ("points", "pairs", "words"),
    [
        (V, [("unit", "port"), ("unit", "stern")], "a cable ends at stern, which is none of port"),
        (V, [("unit", "unit")], "a cable goes from unit to itself"),
        ({**V, "loose": load(0.0, 0.0, 0.0)}, [("unit", "port")], "no cable leads from loose to a held point"),
        (V, [], "no cable leads from unit to a held point"),
    ],
)
def test_a_network_that_is_none_is_refused(points, pairs, words):
    with pytest.raises(StaticsError, match=words):
        solve_network(points, [NetworkCable(*pair, cable(100.0)) for pair in pairs])


def test_a_current_that_no_equilibrium_withstands_is_said(monkeypatch):
    monkeypatch.setattr("heave_statics.network.ITERATIONS", 3)
    ropes = [NetworkCable("unit", end, cable(100.0)) for end in ("port", "starboard")]
    with pytest.raises(NoEquilibriumError, match="no equilibrium was found"):
        solve_network(V, ropes, Current((3.0, 0.0)))


# --- the file

PLANT = CableSimParameters(current=(0.3, 0.1))
ALONE = "points: {}\ncables: {lift: {from: unit, to: boom_tip}}\n"
UMBILICAL = "points: {stern: {at: [-30, 8, 5]}}\ncables:\n  lift: {from: unit, to: boom_tip}\n" + (
    "  umbilical: {from: unit, to: stern, length: 330, diameter: 0.03, mass_per_length: 1.2, axial_stiffness: 5e6}\n"
)


def report_of(text, tmp_path, plant=PLANT):
    path = tmp_path / "net.yaml"
    path.write_text(text, encoding="utf-8")
    return network_report(plant, path, (0.0, 0.0, 0.0))


def test_the_scenarios_rope_alone_hangs_as_without_a_network(tmp_path):
    (lift,) = report_of(ALONE, tmp_path).rows
    hung = shape_at_rest(PLANT, lambda one: towing_cable(one, (0.0, 0.0, 0.0), current_of(PLANT)))
    assert lift.shape.positions[0] == pytest.approx(hung.positions[0], abs=1e-5)
    assert lift.shape.top_tension == pytest.approx(hung.top_tension, rel=1e-8)


def test_the_umbilical_takes_a_part_of_the_load_and_the_lift_line_the_rest(tmp_path):
    report = report_of(UMBILICAL, tmp_path)
    lift, umbilical = report.rows
    pulls = lift.shape.lower[0] + umbilical.shape.lower[0]
    weight = PLANT.unit.weight_in_fluid(PLANT.water_density, PLANT.gravity)
    drag = 0.5 * PLANT.water_density * 0.75 * np.array([0.3 * 0.3, 0.1 * 0.1, 0.0])  # per axis, C_D S = 0.75 m^2
    assert pulls == pytest.approx([-drag[0], -drag[1], weight], abs=0.05)
    assert report.largest_tension == lift.shape.top_tension


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("points: {}\n", "must have the tables points and cables"),
        (ALONE.replace("to: boom_tip", "length: 3"), "a cable needs from and to"),
        (ALONE.replace("boom_tip}", "boom_tip, diameter: 0.03}"), "a cable of its own needs its length"),
        (UMBILICAL.replace("diameter", "diametre"), "diametre"),
        (UMBILICAL.replace("length: 330", "length: 330, catalogue: string"), "no cable string in the catalogue"),
        (UMBILICAL.replace("at: [-30, 8, 5]", "at: [-30, 8]"), "stern: at: must be three numbers"),
        (UMBILICAL.replace("at: [-30, 8, 5]", "ad: [-30, 8, 5]"), "a point has at, or force"),
        (UMBILICAL.replace("at: [-30, 8, 5]", "at: [-30, much, 5]"), "stern: at: must be a finite number; got 'much'"),
        (UMBILICAL.replace("at: [-30, 8, 5]", "drag_area: wide"), "stern: drag_area: must be a finite number"),
        (UMBILICAL.replace("at: [-30, 8, 5]", "drag_area: -3"), "stern: drag_area: must be a finite number from 0 up"),
        (UMBILICAL.replace("length: 330", "length: long"), "umbilical: length: must be a finite number"),
    ],
)
def test_a_wrong_file_is_refused_with_its_name(text, words, tmp_path):
    with pytest.raises(ParameterError, match=words) as refused:
        report_of(text, tmp_path)
    assert "net.yaml: " in str(refused.value)


def test_the_command_prints_draws_and_writes_it(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "net.yaml").write_text(UMBILICAL, encoding="utf-8")
    assert main(["static", "s300_driven", "--network", "net.yaml", "--json", "result.json"]) == 0
    result = json.loads((tmp_path / "result.json").read_text(encoding="utf-8"))
    assert [one["name"] for one in result["cables"]] == ["lift", "umbilical"]
    assert result["points_m"]["stern"] == [-30.0, 8.0, 5.0]
    assert "umbilical  unit" in capsys.readouterr().out
    assert (tmp_path / "s300_driven_network.svg").is_file()
