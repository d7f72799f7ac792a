"""The sea that moves the vessel acts on cable and unit: phase, spectrum, and the same numbers whatever carries it."""

import math
from dataclasses import replace

import numpy as np
import pytest
from cable_sim_node.line import layout as at
from cable_sim_node.line.forces.waves import add_waves, surface_at
from cable_sim_node.line.grid import build_line, with_waves
from cable_sim_node.parameters import CableSimParameters
from heave_bags.analyse import kpi_set
from heave_bringup.cli import main
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.run.loop_signals import run_signals
from heave_bringup.scenarios import load_scenario
from heave_msgs.msg import WaveComponents
from heave_node.numerics.compiled import kernel
from heave_node.numerics.constants import STANDARD_GRAVITY
from rclpy.serialization import deserialize_message
from wave_vessel_node.component import WaveVessel
from wave_vessel_node.parameters import (
    CourseParameters,
    LaterSeaParameters,
    SpreadingParameters,
    VesselParameters,
    WaveVesselParameters,
)

from cable_sim_node import conversions as plant_messages
from wave_vessel_node import conversions as vessel_messages

TICK = 0.05
OTHERS = ("encounter_frequency", "amplitude", "phase", "direction")
HEIGHT, PERIOD = 2.0, 9.0


def line_in(waves):
    return with_waves(build_line(CableSimParameters(length=10.0, segments=2), 20.0), waves)


@kernel
def surface(line, time):
    return surface_at(line, 0.0, 0.0, time)[0]


@kernel
def speeds(line, z, times, out):
    tile = line.tiles[0]
    for i in range(len(times)):
        tile[at.FLOW_X] = tile[at.FLOW_Y] = tile[at.FLOW_Z] = 0.0
        add_waves(line, 0.0, 0.0, z, times[i], tile, 0)
        out[i, 0], out[i, 1] = tile[at.FLOW_X], tile[at.FLOW_Z]


SEAS = {
    "second order": WaveVesselParameters(significant_wave_height=HEIGHT, peak_period=PERIOD, components=200),
    "short-crested": WaveVesselParameters(components=60, spreading=SpreadingParameters(exponent=4.0), ramp=0.0),
    "RAOs under way": WaveVesselParameters(
        components=60,
        direction=2.5,
        vessel=VesselParameters(model="rao", boom_tip_arm=(20.0, -15.0, 10.0)),
        course=CourseParameters(heading=0.7, speed=2.0),
    ),
    "regular": WaveVesselParameters(boom_tip_source="regular", amplitude=(0.0, 0.0, 0.8), period=8.0),
}


@pytest.mark.parametrize("name", SEAS)
def test_the_surface_at_the_boom_tip_is_the_wave_elevation_of_the_vessel(name):
    sea = WaveVessel(SEAS[name], seed=3, tick_period=TICK)
    line = line_in(sea.waves())
    ramped = (1, 7, 200, 900, 1199, 1200, 5000)
    for tick in range(1, max(ramped) + 1):
        outputs = sea.step(tick)
        if tick in ramped:
            assert surface(line, (tick + 1) * TICK) == pytest.approx(outputs.wave_elevation, abs=1e-9)


def bretschneider(omega):
    """Return S(omega) of HEIGHT and PERIOD [m^2 s/rad], after its text-book form."""
    peak = 2.0 * math.pi / PERIOD
    return 5.0 / 16.0 * HEIGHT**2 * peak**4 / omega**5 * np.exp(-1.25 * (peak / omega) ** 4)


@pytest.mark.parametrize("depth", [0.0, 5.0, 20.0])
def test_the_waters_speed_has_the_variance_of_the_spectrum(depth):
    """Integral of S omega^2 e^{-2 k d}, for the speed along the waves and up; sampled at 40,000 moments, 1 %."""
    sea = replace(SEAS["second order"], components=800, ramp=0.0, direction=0.0)
    line = line_in(WaveVessel(sea, seed=5, tick_period=TICK).waves())
    times, found = np.random.default_rng(1).uniform(0.0, 1e6, 40_000), np.empty((40_000, 2))
    speeds(line, -depth, times, found)
    # the sea carries its tail beyond 1e-4 of the energy in its last component: so does what is compared
    omega = np.linspace(0.2, 2.0 * math.pi / PERIOD * (1.25 / 1e-4) ** 0.25, 20_001)
    by_hand = np.trapezoid(bretschneider(omega) * omega**2 * np.exp(-2.0 * omega**2 / STANDARD_GRAVITY * depth), omega)
    assert np.var(found, axis=0) == pytest.approx([by_hand, by_hand], rel=0.03)


def test_the_surface_has_the_height_of_the_sea():
    line = line_in(WaveVessel(replace(SEAS["second order"], ramp=0.0), seed=5, tick_period=TICK).waves())
    times = np.random.default_rng(1).uniform(0.0, 1e6, 20_000)
    assert 4.0 * np.std([surface(line, time) for time in times]) == pytest.approx(HEIGHT, rel=0.02)


@pytest.mark.parametrize(
    "sea",
    [
        WaveVesselParameters(boom_tip_source="filter"),
        WaveVesselParameters(later_sea=LaterSeaParameters(duration=60.0)),
    ],
)
def test_a_sea_whose_components_do_not_last_has_none(sea):
    assert not len(WaveVessel(sea, seed=1, tick_period=TICK).waves().frequency)


@pytest.mark.parametrize("setting", ["wave_vessel.boom_tip_source=filter", "wave_vessel.later_sea.duration=60"])
def test_a_run_with_such_a_sea_on_the_unit_is_refused_in_a_line_before_it_starts(tmp_path, capsys, setting):
    place = str(tmp_path / "out")
    assert main(["run", "b11_splash_zone", "--bag", place, "--set", setting]) != 0
    said = capsys.readouterr().err.strip()
    assert "\n" not in said
    assert "b11_splash_zone.yaml: cable_sim: wave.source = sea, but this sea has no components" in said
    assert not (tmp_path / "out").exists()


def test_the_unit_of_a_loop_feels_the_sea_and_its_shadow_too():
    settings = ["system.length=20", "cable_sim.segments=2", "all.duration=20", "wave_vessel.ramp=5"]
    felt = {}
    for source in ("none", "sea"):
        scenario = load_scenario("b2_calm_300", settings=[*settings, f"cable_sim.wave.source={source}"])
        loop = ClosedLoop(loop_parameters(scenario))
        record = loop.run()
        felt[source] = [record.column(name) for name in ("top_tension", "uncompensated_tension")]
    for sea, still in zip(felt["sea"], felt["none"], strict=True):
        assert np.abs(sea - still).max() > 20.0


def test_the_components_travel_bit_for_bit():
    waves = WaveVessel(SEAS["RAOs under way"], seed=3, tick_period=TICK).waves()
    received = plant_messages.waves_of(deserialize_message(vessel_messages.waves_message(waves), WaveComponents))
    assert (received.start, received.ramp) == (waves.start, waves.ramp) == (TICK, 60.0)
    for sent, taken in zip(waves.columns, received.columns, strict=True):
        assert np.array_equal(sent, taken)


def test_components_that_are_no_numbers_or_differ_in_length_are_refused_on_receipt():
    for columns in ({"frequency": [1.0]}, {name: [math.nan] for name in ("frequency", *OTHERS)}):
        with pytest.raises(ValueError, match="wave components"):
            plant_messages.waves_of(WaveComponents(**columns))


@pytest.mark.slow
def test_the_lift_of_b11_gets_through_the_surface_within_its_criteria():
    scenario = load_scenario(
        "b11_splash_zone", settings=["all.duration=200", "winch_controller.alarms.tension_ratio=1.3"]
    )
    parameters = loop_parameters(scenario)
    loop = ClosedLoop(parameters)
    static_tension = loop.controller.design.cable.static_tension
    record = loop.run()
    figures = kpi_set.evaluate(run_signals(record, parameters), scenario.run.transient, scenario.run.duration)
    # controller and plant: one static tension, in air at the start
    assert static_tension == pytest.approx(record.column("top_tension")[0], rel=2e-3)
    assert "TENSION_HIGH" not in {alarm.name for _, alarm in record.alarms}
    assert [criterion.kpi for criterion in scenario.wanted if not criterion.is_met(figures[criterion.kpi])] == []
    assert record.column("unit")[0] > 7.9
    assert record.column("unit")[-1] < -10.0


def tension_in_air(*settings):
    """Return the standard deviation of the top tension at deck height [N]."""
    names = ("wave_vessel.ramp=20.0", "winch_controller.programme.move_times=[1000.0]", *settings)
    parameters = replace(loop_parameters(load_scenario("b11_splash_zone", settings=names)), seed=301, duration=55.0)
    return float(np.std(ClosedLoop(parameters).run().column("top_tension", after=35.0)))


@pytest.mark.long
def test_a_frugal_law_shakes_a_unit_on_a_short_wire_less():
    """Most of the tension's deviation in air is noise of the MRU that the law passes on to the wire's resonance."""
    frugal = [f"winch_controller.mpc.{name}payout_acceleration=0.1" for name in ("", "free_")]
    assert tension_in_air(*frugal) < 0.8 * tension_in_air()
