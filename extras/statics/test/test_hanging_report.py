import dataclasses
import math
import re

import numpy as np
import pytest
from cable_sim_node.errors import PlantError, StaticsError
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.parameters import (
    CableParameters,
    CableSimParameters,
    ClumpsParameters,
    CurrentProfileParameters,
    SeabedParameters,
    SectionsParameters,
    UnitParameters,
)
from cable_sim_node.reports.modes import modes_report
from cable_sim_node.reports.report import save_picture
from heave_statics.reports.hanging import hanging_report

PNG_HEAD = b"\x89PNG\r\n\x1a\n"

RICH = CableSimParameters(
    segments=200,
    current_profile=CurrentProfileParameters((0.0, 150.0, 300.0), (0.4, 0.15, -0.1), (0.0, 0.2, 0.05)),
    sections=SectionsParameters((60.0,), (0.06,), (0.0,), (9.0,), (8e6,)),
    clumps=ClumpsParameters((150.0,), (800.0,), (0.2,), (0.0,), (0.5,)),
)


def test_in_still_water_the_report_is_weight_and_stretch():
    parameters = CableSimParameters(surface=False)
    report = hanging_report(parameters, (1.0, 2.0, 3.0))
    unit = parameters.unit.weight_in_fluid(1025.0)
    weight = parameters.cable.weight_in_fluid(1025.0)
    stretch = (unit * 300.0 + 0.5 * weight * 300.0**2) / parameters.cable.axial_stiffness
    assert report.largest_tension == pytest.approx(unit + 300.0 * weight)
    assert report.unit == pytest.approx([1.0, 2.0, 3.0 - 300.0 - stretch])
    assert report.shape.top_angle == pytest.approx(0.0, abs=1e-12)
    assert report.unit_pull == pytest.approx([0.0, 0.0, unit])


def test_pressure_shortens_the_cable_by_the_integral_of_pressure_and_area_over_ea():
    """Pinto, Eq. 16: rho g A L^2/(2 EA) over a depth of L. Steel wire of 40 mm, 3,000 m: 0.56 m.

    The printed term is rho A y, without g: 0.06 m, and a mass where a force belongs.
    """
    wire = CableParameters(diameter=0.040, displaced_diameter=0.032, mass_per_length=6.54, axial_stiffness=6.46e7)
    unit = UnitParameters(mass=2e4, volume=2.0)
    report = hanging_report(CableSimParameters(length=3000.0, cable=wire, unit=unit))
    by_hand = 1025.0 * 9.80665 * math.pi / 4.0 * 0.032**2 * 3000.0**2 / (2.0 * 6.46e7)
    assert by_hand == pytest.approx(0.563, abs=1e-3)
    # the unit hangs deeper by the stretch, so does every point of the cable
    assert report.pressure_shortening == pytest.approx(by_hand, rel=0.01)


@pytest.mark.parametrize(
    "parameters",
    [
        CableSimParameters(segments=200, current=(0.5, 0.2)),
        RICH,
        dataclasses.replace(RICH, cable=CableParameters(stiffness_quadratic=40.0, stiffness_cubic=500.0)),
    ],
    ids=["uniform current", "sections, clump, sheared current", "nonlinear tension law"],
)
def test_the_report_agrees_with_the_line_that_dynamics_starts_from(parameters):
    # two codes: the closed form of distributed weight and drag, and the lumped line
    report = hanging_report(parameters)
    line = CableDynamics(parameters)
    line.start_at_equilibrium(np.zeros(3))
    assert report.unit == pytest.approx(line.unit_position, abs=2e-3)
    assert report.boom_tip_force == pytest.approx(-line.top_force, rel=1e-4, abs=1.0)


def test_the_angle_is_that_of_the_force_and_the_azimuth_points_downstream():
    report = hanging_report(CableSimParameters(current=(0.3, 0.4)))
    horizontal, vertical = math.hypot(*report.boom_tip_force[:2]), report.boom_tip_force[2]
    assert report.shape.top_angle == pytest.approx(math.atan2(horizontal, vertical))
    # drag per axis on the unit is not along the current, so only nearly
    assert math.degrees(report.top_azimuth) == pytest.approx(math.degrees(math.atan2(0.4, 0.3)), abs=1.0)


def test_the_table_says_every_number_with_its_unit():
    report = hanging_report(dataclasses.replace(RICH, seabed=SeabedParameters(depth=320.0)))
    table = report.table()
    for words in ("top tension [kN]", "top angle", "unit [m]", "force on the cable at the boom tip [kN]", "seabed [m]"):
        assert words in table
    assert f"{report.largest_tension / 1e3:.3f}" in table
    values = report.values()
    assert values["top_tension_n"] == pytest.approx(report.largest_tension)
    assert values["clearance_m"] == pytest.approx(320.0 + report.unit[2])
    assert all(np.all(np.isfinite(value)) for value in values.values())


SOFT = CableParameters(axial_stiffness=1e3)
YIELDING = CableParameters(stiffness_quadratic=-1e4)
BUOYANT = UnitParameters(mass=1.0, volume=1.0)
WRONG = {
    # a unit of 1 m^3 and 1 kg pulls up with 10 kN, the cable in water down with some hundred N
    "the unit's buoyancy lifts it above the boom tip": CableSimParameters(length=20.0, unit=BUOYANT),
    "it would part; check cable.axial_stiffness": CableSimParameters(cable=SOFT),
    "tension law carries no load at the static strain: with stiffness_quadratic = -10000": CableSimParameters(
        cable=YIELDING
    ),
    "m below the seabed": CableSimParameters(seabed=SeabedParameters(depth=250.0)),
}


@pytest.mark.parametrize("says", WRONG)
def test_statics_and_modes_refuse_the_same_for_the_same_cause(says):
    for report in (hanging_report, lambda parameters: modes_report(parameters, sea_period=8.0)):
        with pytest.raises(PlantError, match=re.escape(says)) as refused:
            report(WRONG[says])
        assert "\n" not in str(refused.value)


@pytest.mark.parametrize("says", list(WRONG)[::2])
def test_the_plant_names_the_same_cause_where_it_does_not_hang(says):
    with pytest.raises(PlantError, match=re.escape(says)):
        CableDynamics(WRONG[says]).start_at_equilibrium(np.zeros(3))


def test_a_unit_below_the_seabed_is_refused():
    with pytest.raises(StaticsError, match="below the seabed"):
        hanging_report(CableSimParameters(seabed=SeabedParameters(depth=290.0)))


def test_a_report_of_a_cable_shorter_than_its_sections_uses_what_is_out():
    short = dataclasses.replace(RICH, length=40.0, clumps=ClumpsParameters())
    assert hanging_report(short).shape.cable.length == pytest.approx(40.0)


def test_a_clump_beyond_the_cable_is_refused():
    with pytest.raises(PlantError, match="not on the cable"):
        hanging_report(dataclasses.replace(RICH, length=100.0))


def test_the_picture_is_written_in_the_format_of_its_name(tmp_path):
    report = hanging_report(dataclasses.replace(RICH, seabed=SeabedParameters(depth=320.0)))
    save_picture(report, tmp_path / "shape.png")
    save_picture(report, tmp_path / "shape.svg")
    assert (tmp_path / "shape.png").read_bytes()[:8] == PNG_HEAD
    assert "<svg" in (tmp_path / "shape.svg").read_text(encoding="utf-8")
    with pytest.raises(PlantError, match=r"\.png or \.svg"):
        save_picture(report, tmp_path / "shape.gif")
