"""Cable, unit and MRU from a record whose truth is known, and what is known before a record."""

import math
from dataclasses import replace

import numpy as np
import pytest
from cable_sim_node.winch.parameters import WinchParameters
from heave_bringup.scenarios import load_scenario
from heave_node.interface.sensors import MruReading
from heave_studies.whatif import twin as plant
from heave_studies.whatif.identify import (
    DELAY,
    INERTIA,
    SCALE,
    STIFFNESS,
    USUAL,
    CableFit,
    Evidence,
    fit_cable,
    prior_of,
)
from heave_studies.whatif.record import SensorRecord
from heave_studies.whatif.spectra import HighPass, Tip, TipSource, smoothed_tip
from heave_studies.whatif.twin import PastWinch
from winch_controller_node.beliefs.beliefs import AS_READ
from winch_controller_node.interface.readings import Measurements, ScalarReading

TICK = 0.05
TIME = TICK * np.arange(1, 2801)
TRUE = {INERTIA: 1.1, STIFFNESS: 0.95, SCALE: 1.01}
"""The rest of the world is as assumed."""


@pytest.fixture(scope="module")
def nominal():
    return load_scenario("b4_limit_900_tp10").parameters["winch_controller"]


def sea(sigma):
    """Return heave and rate of a boom tip with waves on both sides of the resonance at 17 s: sigma in metres."""
    random = np.random.default_rng(11)
    omegas = np.sort(random.uniform(0.28, 1.5, 80))
    phases = omegas[:, None] * TIME + random.uniform(0.0, 2.0 * math.pi, (80, 1))
    share = np.clip(TIME / 30.0, 0.0, 1.0)
    heave = share * share * (3.0 - 2.0 * share) * (sigma * math.sqrt(2.0 / 80.0) * np.sin(phases)).sum(axis=0)
    return heave, np.gradient(heave, TICK)


def evidence(nominal, monkeypatch, heave, rate):
    """Return evidence under a still winch, of a plant with other factors and a finer mesh than the twin's."""
    random = np.random.default_rng(7)
    still = np.zeros(len(TIME))
    factors = plant.PlantFactors(inertia=TRUE[INERTIA], stiffness=TRUE[STIFFNESS])
    line = plant.scaled_line(plant.nominal_line(nominal), factors)
    with monkeypatch.context() as finer:
        finer.setattr(plant, "SEGMENTS", 30)
        finer.setattr(plant, "SUBSTEPS", 8)
        drive = plant.Drive(line, nominal.length, Tip(heave, rate, 0.0), still, still, TICK)
        motion = plant.driven(drive)
    noise = random.standard_normal((4, len(TIME)))
    rows = zip(
        TIME,
        TRUE[SCALE] * heave + 0.01 * noise[0],
        TRUE[SCALE] * rate + 0.01 * noise[1],
        -motion.unit + 0.02 * noise[2],
        motion.tension + 500.0 * noise[3],
        strict=True,
    )
    given = tuple(
        Measurements(
            (MruReading(float(t), float(z), float(v)),),
            {"depth": (ScalarReading(float(t), float(d)),), "load_cell": (ScalarReading(float(t), float(c)),)},
        )
        for t, z, v, d, c in rows
    )
    count = len(TIME)
    record = SensorRecord(TICK, 1, given, (None,) * count, np.full(count, math.nan), ("",) * count)
    source = TipSource(TIME, smoothed_tip(record, AS_READ, HighPass()), HighPass())
    winch = PastWinch(WinchParameters(), still, still, still, still, 0.0)
    return Evidence(record, nominal, plant.nominal_line(nominal), source, winch, 1.0), motion


@pytest.mark.long
def test_cable_unit_and_mru_are_found_with_their_spread(nominal, monkeypatch):
    given, _ = evidence(nominal, monkeypatch, *sea(0.3))
    fit = fit_cable(given)
    for name, true in TRUE.items():
        assert abs(math.log(fit.values[name] / true)) < 3.0 * fit.sigma(name), name
        assert fit.tells(name), name
    assert abs(fit.values[DELAY]) < 3.0 * fit.sigma(DELAY)
    # noise is all that is left: chi2 of some 130 values is 1 within three of its standard deviations
    assert fit.chi2 == pytest.approx(1.0, abs=3.0 * math.sqrt(2.0 / 130.0))


def test_what_the_tip_leaves_open_does_not_depend_on_where_a_narrow_resonance_lies_among_the_bins(nominal, monkeypatch):
    given, _ = evidence(nominal, monkeypatch, *sea(0.005))
    values = dict.fromkeys(USUAL, 1.0) | {DELAY: 0.0}
    moved = []
    for end in np.linspace(125.0, 140.0, 6):
        monkeypatch.setattr(Evidence, "end", float(end))
        one = replace(given)
        shared = one.covariance(values, np.zeros(2))[:, 0, 0].real
        moved.append(float(np.sum(shared) * (one.omegas[1] - one.omegas[0])))
    # Parseval: the sum over the bins is the integral of the density, and a record of 110 s for 95 rings for longer;
    # a resonance between two frequencies that were looked at, or on one, made a factor of 1,000 of it
    assert max(moved) < 1.2 * min(moved)


def test_an_uncertain_mru_widens_the_prior(nominal):
    # as the controller's own parameters say it
    mru = replace(nominal.sensors.mru, scale_sigma=0.05)
    uncertain = replace(nominal, sensors=replace(nominal.sensors, mru=mru))
    assert prior_of(uncertain)[SCALE] == 0.05


def test_a_value_is_known_where_the_record_says_more_than_was_known_before(nominal):
    for sigma, is_known in ((0.02, True), (0.12, False)):
        fit = CableFit({INERTIA: 1.0}, np.array([[sigma**2]]), prior_of(nominal), 1.0)
        assert fit.tells(INERTIA) == is_known


def test_a_long_record_is_judged_by_its_last_part(nominal):
    # an hour of identification would take an hour's memory: 900 s, and 180 s in which the twin settles
    time = TICK * np.arange(1, 72001)
    record = SensorRecord(TICK, 1, (Measurements((), {}),) * 72000, (None,) * 72000, np.zeros(72000), ("",) * 72000)
    still = np.zeros(72000)
    tip = Tip(still, still, 0.01)
    source = TipSource(time, tip, HighPass())
    winch = PastWinch(WinchParameters(), still, still, still, still, 0.0)
    given = Evidence(record, nominal, plant.nominal_line(nominal), source, winch, 1.0)
    assert given.start == 2700.0
    assert record.time[given.ticks][0] == pytest.approx(2520.0)
    assert record.time[given.ticks][-1] == pytest.approx(3600.0)
