"""The loop in one process is the loop over ROS: a bag holds its numbers, to the last bit."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from heave_bags.analyse import kpi_set
from heave_bags.analyse.read_run import read_run
from heave_bags.mcap.reader import Bag
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.run.loop_signals import run_signals
from heave_bringup.scenarios import load_scenario
from heave_studies.baseline import add_baseline
from heave_studies.study.case_file import write_case
from heave_studies.study.cases import Cases
from heave_studies.study.engine import run_study
from heave_studies.study.study_file import read_study
from winch_controller_node.interface.readings import Outputs

from tests.loop_runs import recorded_messages, run_scenario

NOT_OF_ONE_PROCESS = {"nis_in_band_percent", "real_time_factor", "missed_deadlines", "compensation_losses"}
"""The last counts what nobody had requested, which the reason of a mode shows: a study says it in words."""
OTHER_WATER = {
    "cable_sim.water_density": "1030",
    "cable_sim.gravity": "9.83",
    "cable_sim.sensors.imu.fitted": "true",
    "virtual_winch.acceleration_limit": "0.3",
    "virtual_winch.stop_deceleration": "0.3",
    "winch_controller.gravity": "9.82",
    "winch_controller.sensors.use": "[mru, depth, encoder, imu]",
    "winch_controller.modes.settling_time": "5",
    "winch_controller.modes.fade_in_time": "5",
}
PREVIEW = {
    "wave_vessel.preview.time": "3.0",
    "wave_vessel.ramp": "5.0",
    "winch_controller.mpc.preview_time": "2.0",
    "winch_controller.modes.settling_time": "5",
    "winch_controller.modes.fade_in_time": "5",
}

LOAD_RESPONSE = {
    "wave_vessel.load_response.displacement": "60000.0",
    "wave_vessel.load_response.waterplane_area": "20.0",
    "wave_vessel.ramp": "2.0",
    "winch_controller.modes.settling_time": "2",
    "winch_controller.modes.fade_in_time": "2",
}
WAVES = {
    "system.length": "20.0",
    "cable_sim.segments": "2",
    "cable_sim.wave.source": "sea",
    "wave_vessel.components": "60",
    "wave_vessel.ramp": "5.0",
    "winch_controller.modes.settling_time": "2",
}


def compare(bag: Path) -> None:
    """Run the scenario that the run in `bag` stored again in one process, and compare."""
    scenario = load_scenario(str(bag.parent / "scenario.yaml"))
    parameters = loop_parameters(scenario)
    outputs, reported = [], []

    def note(_: int, of_tick: Outputs) -> None:
        outputs.append(of_tick)
        reported.append(list(of_tick.report.estimate))

    record = ClosedLoop(parameters).run(note)
    recorded = Bag(bag)
    commands = [m for _, m in recorded.decoded(["winch/command"])]
    for name in ("sequence", "payout", "payout_rate", "brake"):
        assert [getattr(m, name) for m in commands] == [getattr(o.order, name) for o in outputs], name
    estimates = [list(m.estimate) for _, m in recorded.decoded(["controller/state"])]
    assert estimates == reported
    unit = [m.pose.pose.position.z for _, m in recorded.decoded(["unit/odometry"])]
    np.testing.assert_allclose(unit, record.column("unit"), rtol=0.0)
    start, end = 0.5 * scenario.run.duration, scenario.run.duration
    of_bag = read_run(bag).kpis(start, end)
    of_loop = kpi_set.evaluate(run_signals(record, parameters), start, end)
    known = [key for key in of_bag if np.isfinite(of_bag[key]) and not key.startswith("loop_age")]
    assert len(known) > 20
    for key in set(known) - NOT_OF_ONE_PROCESS:
        assert of_loop[key] == of_bag[key], key


def test_a_run_over_ros_is_the_run_in_one_process(calm_bag):
    compare(calm_bag)


@pytest.mark.slow
@pytest.mark.long
def test_so_it_is_in_water_and_gravity_other_than_believed_and_at_the_limits_of_the_winch(tmp_path):
    options = [part for name, value in OTHER_WATER.items() for part in ("--set", f"{name}={value}")]
    compare(run_scenario(tmp_path / "run", duration=25.0, options=options))


@pytest.mark.long
def test_so_it_is_with_a_ship_that_answers_to_its_load(tmp_path):
    """A tenth of the ship's mass, and in a process each: the vessel waits for the tension of each tick."""
    options = [part for name, value in LOAD_RESPONSE.items() for part in ("--set", f"{name}={value}")]
    compare(run_scenario(tmp_path / "run", duration=10.0, options=options))


@pytest.mark.long
def test_so_it_is_with_the_sea_on_cable_and_unit_and_with_that_sea_from_its_bag(tmp_path):
    """First with all nodes in one process, then in a process each with the bag in the place of the vessel."""
    options = [part for name, value in WAVES.items() for part in ("--set", f"{name}={value}")]
    bag = run_scenario(tmp_path / "run", duration=8.0, options=[*options, "--composed"])
    compare(bag)
    again = run_scenario(tmp_path / "again", duration=8.0, options=[*options, "--replace", f"wave_vessel=bag:{bag}"])
    assert recorded_messages(again) == recorded_messages(bag)
    waves = [message for _, message in Bag(bag).decoded(["wave_components"])]
    assert [len(message.amplitude) for message in waves] == [60]


@pytest.mark.slow
@pytest.mark.long
def test_so_it_is_with_a_preview_of_the_boom_tip_which_is_in_the_bag(tmp_path):
    options = [part for name, value in PREVIEW.items() for part in ("--set", f"{name}={value}")]
    bag = run_scenario(tmp_path / "run", duration=25.0, options=options)
    compare(bag)
    previews = [message for _, message in Bag(bag).decoded(["vessel/heave_preview"])]
    assert len(previews) == 25.0 / 0.05
    assert len(previews[0].ahead) == len(previews[0].heave) == 60
    heave = [message.position.z for _, message in Bag(bag).decoded(["boom_tip"])]
    error = np.array([message.heave[0] for message in previews]) - heave
    # 0.05 m, of 500 samples: within four standard errors
    assert np.std(error) == pytest.approx(0.05, abs=4 * 0.05 / np.sqrt(1000))


@pytest.mark.slow
@pytest.mark.long
def test_a_case_of_a_table_has_the_figures_of_its_row_over_ros_in_a_bag(tmp_path):
    settings = ", ".join(f"{name}: {value}" for name, value in OTHER_WATER.items())
    file, table = tmp_path / "own.yaml", tmp_path / "own" / "table.parquet"
    file.write_text(
        "scenario: b2_calm_300\nduration: 25\nseeds: [3]\n"
        f"set: {{all.transient: 12, {settings}}}\nvary: {{winch_controller.law: [off, mpc]}}\n"
    )
    frame = run_study(Cases(read_study(file)), table.parent, processes=1)[0].set_index("case")
    assert frame.loc[2, "compensating_percent"] > 0.0
    for number, law in ((1, "off"), (2, "mpc")):
        case = write_case(f"{table}:{number}", tmp_path / f"{law}.yaml")
        record = read_run(run_scenario(tmp_path / law, str(case), duration=25.0))
        of_bag, row = record.kpis(), frame.loc[number]
        known = [key for key in of_bag if np.isfinite(of_bag[key]) and not key.startswith("loop_age")]
        assert len(known) > 20
        for key in set(known) - NOT_OF_ONE_PROCESS:
            assert row[key] == of_bag[key], key


def test_a_run_without_a_preview_has_no_topic_for_it(calm_bag):
    assert "/vessel/heave_preview" not in Bag(calm_bag).topics


def test_the_baseline_beside_a_bag_is_law_industrial_in_its_sea(calm_bag):
    scenario = load_scenario(str(calm_bag.parent / "scenario.yaml"))
    controller = replace(scenario.parameters["winch_controller"], law="industrial")
    parameters = replace(loop_parameters(scenario), controller=controller)
    record = read_run(calm_bag)
    assert np.isnan(record.kpis()["baseline_efficiency"])
    add_baseline(record, calm_bag)
    start, end = 0.5 * scenario.run.duration, scenario.run.duration
    expected = kpi_set.evaluate(run_signals(ClosedLoop(parameters).run(), parameters), start, end)
    assert record.kpis(start, end)["baseline_efficiency"] == expected["unit_efficiency"]
