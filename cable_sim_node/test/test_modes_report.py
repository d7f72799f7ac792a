import dataclasses
import math

import numpy as np
import pytest
from cable_sim_node.errors import LinearisationError
from cable_sim_node.parameters import CableParameters, CableSimParameters, RopePathParameters, SeabedParameters
from cable_sim_node.reports.modes import modes_report
from cable_sim_node.unit_parameters import OscillationParameters, UnitParameters
from scipy.optimize import brentq

from tests.validation.peers.reference_systems import s900


@pytest.fixture(scope="module")
def deep():
    return modes_report(s900(40), sea_period=10.0)


def test_the_first_heave_period_of_the_900_m_system_is_that_of_the_cot_equation(deep):
    # k L tan(k L) = m L/M for a bar with a mass below
    length, mass, inertia, stiffness = 900.0, 7.2, 125e3, 1.57706e7
    x = brentq(lambda x: x * math.tan(x) - mass * length / inertia, 1e-6, 1.5)
    omega = x / length * math.sqrt(stiffness / mass)
    assert deep.heave[0].period == pytest.approx(2.0 * math.pi / omega, rel=1e-6)
    assert deep.heave[0].period == pytest.approx(16.9, abs=0.05)  # thesis 6.2.6


def test_at_the_critical_length_the_cable_resonates_with_the_sea(deep):
    # near 320 m a 10 s swell is in resonance (the peers' figure)
    assert deep.critical_length == pytest.approx(320.0, abs=5.0)
    there = modes_report(dataclasses.replace(s900(10), length=deep.critical_length), sea_period=10.0, longest=900.0)
    assert there.heave[0].period == pytest.approx(10.0, abs=1e-3)
    # the cable's own mass is a third of 2.3 t beside 125 t
    assert deep.critical_estimate == pytest.approx(deep.critical_length, rel=0.01)


def test_the_ridge_of_the_map_is_the_natural_period(deep):
    periods = 2.0 * math.pi / deep.resonances.omegas
    ridge = periods[np.argmax(deep.resonances.unit_heave, axis=1)]
    inside = (deep.natural_periods > 4.0) & (deep.natural_periods < 24.0)
    assert inside.sum() > 20
    assert ridge[inside] == pytest.approx(deep.natural_periods[inside], abs=abs(periods[1] - periods[0]))


def test_what_has_no_part_in_it_is_named(deep):
    stiff = dataclasses.replace(
        s900(40),
        seabed=SeabedParameters(depth=1000.0),
        cable=dataclasses.replace(s900().cable, bending_stiffness=1e4, loss_factor=0.1),
    )
    report = modes_report(stiff, sea_period=10.0)
    assert report.heave[0].period == deep.heave[0].period
    assert "not in the modes: cable.bending_stiffness; cable.loss_factor" in report.table()
    assert len(report.values()["left_out"]) == 2
    assert "not in the modes" not in deep.table()


def test_the_rope_path_is_a_spring_in_series():
    """12 t on 1,500 m of a light rope: w^2 = 1/(M (L/EA + 1/k)), 9.7 s."""
    unit = UnitParameters(mass=12e3, volume=0.0, added_mass=(0.0,) * 3, drag_coefficient=(0.0,) * 3)
    cable = CableParameters(diameter=0.001, mass_per_length=1e-3, axial_stiffness=3e7 * 20.0)
    soft = CableSimParameters(
        length=1500.0, segments=10, cable=cable, unit=unit, rope_path=RopePathParameters(stiffness=2e4)
    )
    period = 2.0 * math.pi * math.sqrt(12e3 * (1500.0 / 6e8 + 1.0 / 2e4))
    report = modes_report(soft, sea_period=8.0)
    assert report.heave[0].period == pytest.approx(period, rel=1e-4)
    assert report.natural_periods[-1] == pytest.approx(period, rel=1e-4)


def test_a_table_over_kc_swings_the_added_mass_of_kc_0():
    table = OscillationParameters(kc=(0.0, 5.0), added_mass=(40e3, 90e3), drag_coefficient=(2.0, 4.0), width=4.0)
    given = dataclasses.replace(s900(10), unit=dataclasses.replace(s900().unit, oscillation=table))
    alike = dataclasses.replace(s900(10), unit=dataclasses.replace(s900().unit, added_mass=(0.0, 0.0, 40e3)))
    report = modes_report(given, sea_period=10.0)
    assert report.heave[0].period == modes_report(alike, sea_period=10.0).heave[0].period
    assert "unit.oscillation (its added mass at KC = 0 is, its drag is not)" in report.table()


def test_table_and_values_name_every_mode(deep):
    values, table = deep.values(), deep.table()
    assert len(values["heave_periods_s"]) == 4
    assert f"{deep.critical_length:.1f} m" in table


def test_a_period_beyond_the_map_has_no_resonant_length():
    report = modes_report(s900(10), sea_period=25.0)
    assert report.critical_length is None
    assert "none on the map" in report.table()


@pytest.mark.parametrize("wrong", [{"sea_period": 0.0}, {"sea_period": 10.0, "count": 0}, {"sea_period": math.nan}])
def test_what_cannot_be_is_refused(wrong):
    with pytest.raises(LinearisationError, match="must be positive"):
        modes_report(s900(10), **wrong)
