"""A campaign from plan to table: ended and begun again, failed cases, dead processes, a row that repeats its case."""

from __future__ import annotations

import io
import json
import subprocess
import sys
import time
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

import numpy as np
import pandas
import pytest
from heave_bags.analyse import kpi_set
from heave_bringup.cli import main
from heave_bringup.closed_loop import COLUMNS, LoopRecord
from heave_bringup.errors import CommandError
from heave_bringup.progress import time_to_go
from heave_bringup.scenarios import load_scenario
from heave_node.interface.alarm import AlarmRow, Severity
from heave_node.parameters import ParameterError
from heave_studies.campaign import executors, picture, runs, study
from heave_studies.campaign.campaign_file import campaign_of, read_campaign
from heave_studies.campaign.plan import Case
from heave_studies.campaign.report import case_table, left_out, remarks, summarise, summary_table, to_json
from heave_studies.campaign.runs import CaseResult, Task, lost_because, make_tasks, run_task
from heave_studies.campaign.table import case_frame
from heave_studies.tables.case_table import read_cases, write_case
from rich.console import Console

TEXT = """
scenario: b2_calm_300
duration: 3
seeds: 2
set: {all.transient: 1.0, wave_vessel.ramp: 0.5, cable_sim.segments: 2}
wanted: {unit_sigma_m: "<= 0.5"}
vary: {winch_controller.law: [off, mpc], system.sea.peak_period: [6.0, 7.0]}
"""


@pytest.fixture
def campaign(tmp_path: Path):
    path = tmp_path / "own.yaml"
    path.write_text(TEXT)
    return read_campaign(path)


def pretended(task: Task) -> CaseResult:
    """Stand for a run: figures that depend on the case alone; case 3 cannot be run, case 5 is lost."""
    if task.case.number == 3:
        return CaseResult(task.case, failure="the cable parted")
    kpis = dict.fromkeys(kpi_set.DEFINITION_OF, 0.1 * task.case.number) | {"snaps": 0.0, "uncompensated_snaps": 0.0}
    return CaseResult(task.case, kpis, "", 0.5, "compensation ended at 2.00 s" if task.case.number == 5 else "")


class KilledError(Exception):
    """What ends a campaign in the middle."""


def test_a_campaign_that_was_ended_goes_on_where_it_was_and_gives_the_same_file(
    campaign, tmp_path, monkeypatch, capsys
):
    monkeypatch.setattr(executors, "run_task", pretended)
    whole, resumed = tmp_path / "whole.parquet", tmp_path / "resumed.parquet"
    study.run_study(campaign, output=whole, processes=1)
    run: list[int] = []

    def ends_after_four(task: Task) -> CaseResult:
        run.append(task.case.number)
        if task.case.number == 5 and len(run) == 5:
            raise KilledError
        return pretended(task)

    monkeypatch.setattr(executors, "run_task", ends_after_four)
    with pytest.raises(KilledError):
        study.run_study(campaign, output=resumed, processes=1)
    assert "resumed.parquet.partial: the same command goes on there" in capsys.readouterr().err
    assert not resumed.exists()
    partial = resumed.with_name("resumed.parquet.partial")
    partial.write_text(partial.read_text() + '{"number": 5, "kp')  # killed within a line
    study.run_study(campaign, output=resumed, processes=1)
    assert run == [1, 2, 3, 4, 5, 5, 6, 7, 8]
    assert resumed.read_bytes() == whole.read_bytes()
    assert not partial.exists()
    assert len(study.run_study(campaign, output=resumed, processes=1)) == 8
    assert len(run) == 9  # nothing was left to be run


def test_the_results_of_another_campaign_are_not_taken(campaign, tmp_path, monkeypatch):
    monkeypatch.setattr(executors, "run_task", pretended)
    output = tmp_path / "cases.parquet"
    output.with_name("cases.parquet.partial").write_text('{"digest": "other"}\n')
    with pytest.raises(ParameterError, match=r"cases\.parquet\.partial: holds results of another campaign"):
        study.run_study(campaign, output=output, processes=1)


def test_a_table_that_could_not_be_written_is_refused_before_the_first_case(campaign, tmp_path, monkeypatch):
    monkeypatch.setattr(executors, "run_task", lambda task: pytest.fail("a case was run"))
    with pytest.raises(ParameterError, match="there is no folder"):
        study.run_study(campaign, output=tmp_path / "nowhere" / "cases.parquet", processes=1)
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(ParameterError, match=r"cases\.parquet: Parquet needs the package pyarrow"):
        study.run_study(campaign, output=tmp_path / "cases.parquet", processes=1)


@pytest.mark.parametrize(
    ("failure", "words"),
    [
        ("its worker was lost: Error during deserialization of the task graph", "the workers need this suite"),
        ("the cable parted", "none of 8 cases ran; the first: the cable parted"),
    ],
)
def test_a_campaign_of_which_no_case_ran_ends_with_status_1(campaign, monkeypatch, tmp_path, capsys, failure, words):
    monkeypatch.setattr(executors, "run_task", lambda task: CaseResult(task.case, failure=failure))
    (tmp_path / "own.yaml").write_text(TEXT)
    assert main(["campaign", str(tmp_path / "own.yaml"), "--processes", "1"]) == 1
    assert words in capsys.readouterr().err


def test_a_failed_case_is_a_row_and_stops_no_other(campaign, monkeypatch):
    monkeypatch.setattr(executors, "run_task", pretended)
    frame = study.run_study(campaign, processes=1)
    assert len(frame) == 8
    assert frame.set_index("case")["failure"].to_dict()[3] == "the cable parted"
    assert np.isnan(frame.set_index("case")["unit_sigma_m"].to_dict()[3])
    assert not frame.set_index("case")["met"].to_dict()[3]
    assert frame.set_index("case")["reason"].to_dict()[5] == "compensation ended at 2.00 s"
    summary = summarise(frame)
    assert (summary["cases"], summary["failed"], summary["lost"]) == (8, 1, 1)
    shown = {column.header.plain: list(map(str, column.cells)) for column in summary_table(frame).columns}  # type: ignore[union-attr]
    assert set(shown) == {"all cases", "off", "mpc", "unit"}, "figures over several laws together would mean nothing"
    of_mpc = summarise(frame[frame["winch_controller.law"] == "mpc"])
    line = shown["all cases"].index("load heave, standard deviation: median of the cases")
    assert (shown["mpc"][line], shown["unit"][line]) == (f"{100.0 * of_mpc['unit_sigma_m_median']:.2f}", "cm")
    assert shown["all cases"].index("snaps") < line < shown["all cases"].index("largest over uncompensated")
    assert to_json(campaign, frame)["summary_by_law"]["mpc"] == of_mpc  # type: ignore[index]
    assert to_json(campaign, frame)["cases"][2]["failure"] == "the cable parted"  # type: ignore[index]
    assert len(case_table(frame).rows) == 8
    assert remarks(frame) == ["case 3: failed: the cable parted", "case 5: lost: compensation ended at 2.00 s"]
    many = pandas.concat([frame] * 30, ignore_index=True)
    assert remarks(many)[-1] == "and 40 cases more, see the columns of --csv FILE"


@pytest.mark.parametrize("columns", [60, 80, 100])
def test_the_table_of_cases_fits_the_terminal_and_its_laws_stay_whole(campaign, monkeypatch, columns):
    monkeypatch.setattr(executors, "run_task", pretended)
    table = case_table(study.run_study(campaign, processes=1))
    console = Console(width=columns, file=io.StringIO())
    shown, line = table.fitted(console)
    console.print(shown)
    lines = console.file.getvalue().splitlines()
    assert max(map(len, lines)) <= columns
    assert sum("law=mpc" in text for text in lines) == 4
    assert "unit cm" in " ".join(lines[:3]) or "unit" in lines[0]
    assert line.startswith("not shown for want of room: ")
    assert len(table.fitted(Console(width=1000, file=io.StringIO()))) == 1, "a file has room for all"


def test_a_campaign_without_a_file_is_every_combination_of_what_is_varied(monkeypatch):
    vary = ["winch_controller.law=off,lqg,mpc", "system.unit.added_mass=[1.0, 1.0, 1.0],[2.0, 2.0, 2.0]"]
    made = campaign_of("b2_calm_300", vary).shortened(duration=200.0, draws=None, seeds=2)
    cases = list(made.cases())
    assert len(cases) == 3 * 2 * 2
    assert {case.settings["winch_controller.law"] for case in cases} == {"off", "lqg", "mpc"}, "off is a law, not False"
    tasks = make_tasks(made, cases[:2])
    assert [task.scenario.run.seed for task in tasks] == [1, 2]
    assert tasks[0].scenario.parameters["cable_sim"].unit.added_mass == (1.0, 1.0, 1.0)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["b2_calm_300", "--vary", "winch_controller.law"], "must be NODE.PARAM=VALUE,VALUE,..."),
        (["b2_calm_300", "--vary", "law=off"], "--vary law=off: law is not a parameter"),
        (["b2_calm_300", "--vary", "winch_controller.law=[off"], "is not a list of YAML values"),
        (["b2_calm_300", "--vary", "winch_controller.lw=off"], "--vary: winch_controller.lw: there is no parameter lw"),
        (["b2_calm_300", "--vary", "winch_controller.law=sail"], "law = 'sail' is not allowed"),
        (["b2", "--vary", "winch_controller.law=off"], "b2: no such scenario"),
        (["b2_calm_300", "--vary", "all.seed=1", "--vary", "all.seed=2"], "--vary all.seed: stands twice"),
        (["b2_calm_300", "--vary", "winch_controller.law=off", "--seeds", "0"], "--seeds 0: must be at least 1"),
        (["b9_model_error", "--set", "winch_controller.law"], "--set winch_controller.law: must be NODE.PARAM=VALUE"),
    ],
)
def test_a_wrong_campaign_of_the_command_line_is_one_line_and_status_2(arguments, words, capsys):
    assert main(["campaign", *arguments]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert said.count("\n") == 1


def test_a_case_that_raises_says_why(campaign, monkeypatch):
    class Parts:
        def __init__(self, parameters: object) -> None:
            raise ValueError("no equilibrium:\n 3 m of cable")

    monkeypatch.setattr(runs, "ClosedLoop", Parts)
    (task, *_) = make_tasks(campaign, list(campaign.cases()))
    assert run_task(task).failure == "no equilibrium: 3 m of cable"


def test_a_case_whose_cable_would_part_is_no_success():
    """36.5 kN at the top over EA = 150 kN are a strain of 24 %, a little less in the middle of the top segment."""
    settings = ("system.cable.axial_stiffness=1.5e5", "cable_sim.segments=5", "all.duration=3", "all.transient=1")
    scenario = load_scenario("s300_driven", settings=settings)
    result = run_task(Task(Case(1, 1, {}), scenario))
    (breach,) = result.breaches
    assert "cable 2" in breach
    assert list(result.missed) == [breach]


def test_a_case_whose_rope_carries_more_than_its_breaking_force_is_no_success():
    """A wire of 28 mm breaks at 494 kN (EN 12385-4); 54 t weigh 530 kN, which strains it by 1.7 %."""
    unit = ("system.unit.mass=54025.0", "system.unit.volume=1.0")
    settings = ("system.cable=wire_28mm_6x36", *unit, "cable_sim.segments=5", "all.duration=3", "all.transient=1")
    result = run_task(Task(Case(1, 1, {}), load_scenario("s300_driven", settings=settings)))
    assert not result.failure
    assert result.kpis["tension_max_n"] > 520e3
    assert result.kpis["rope_safety_factor"] == pytest.approx(494e3 / result.kpis["tension_max_n"], rel=1e-3)
    assert len(result.breaches) == 1
    assert list(result.missed) == list(result.breaches)


class DyingPool:
    """Stands for worker processes: whoever runs case 2 dies, with all that its pool has in hand."""

    def __init__(self, processes: int) -> None:
        self.is_dead = False

    def __enter__(self):
        return self

    def __exit__(self, *error: object) -> None:
        pass

    def submit(self, _: object, task: Task) -> Future[CaseResult]:
        future: Future[CaseResult] = Future()
        self.is_dead |= task.case.number == 2
        if self.is_dead:
            future.set_exception(BrokenProcessPool("a process died"))
        else:
            future.set_result(pretended(task))
        return future


def test_a_process_that_dies_costs_its_own_case_only(campaign, monkeypatch):
    monkeypatch.setattr(executors, "worker_pool", DyingPool)
    results = list(executors.run_tasks(make_tasks(campaign, list(campaign.cases())), processes=2))
    assert sorted(result.case.number for result in results) == list(range(1, 9))
    failures = {result.case.number: result.failure for result in results if result.failure}
    assert failures == {2: executors.DIED, 3: "the cable parted"}


def record_of(modes: list[str], alarms: list[tuple[float, str]]) -> LoopRecord:
    """Return a record with `alarms` of times and codes."""
    rows = np.zeros((len(modes), len(COLUMNS)))
    rows[:, 0] = np.arange(len(modes))
    raised = [(time, AlarmRow(code, Severity.HIGH, "mru", "words").alarm()) for time, code in alarms]
    return LoopRecord(rows, modes, raised)


def test_why_a_case_was_lost_is_when_compensation_ended_and_the_alarm_before():
    scenario = load_scenario("b2_calm_300", settings=["all.transient=3"])
    kpis = {"unit_sigma_m": 0.1, "uncompensated_sigma_m": 0.2}
    on, off = "compensating", "standby"
    whole = record_of([off, on, on, on, on, on], [])
    assert lost_because(whole, scenario, kpis) == ""
    assert "more than uncompensated" in lost_because(whole, scenario, {**kpis, "unit_sigma_m": 0.3})
    ended = record_of([off, on, on, on, "fade_out", on], [(1.0, "FIRST"), (4.0, "MRU_FROZEN"), (5.0, "LATER")])
    assert lost_because(ended, scenario, kpis) == (
        "compensation ended at 4.00 s (mode fade_out), active 66.7 % of the time: MRU_FROZEN (high): words."
    )
    never = record_of([off] * 6, [(2.0, "SEA_ABOVE_WINCH")])
    assert lost_because(never, scenario, kpis) == (
        "compensation never began (mode standby): SEA_ABOVE_WINCH (high): words."
    )
    late = record_of([off, off, off, off, on, on], [])
    assert lost_because(late, scenario, kpis).startswith("compensation began only at 4.00 s")
    locked = load_scenario("b2_calm_300", settings=["winch_controller.law=off"])
    assert lost_because(never, locked, kpis) == ""


def test_a_row_alone_repeats_its_case_and_gives_its_figures(campaign, tmp_path):
    output = tmp_path / "cases.parquet"
    cases = list(campaign.cases())
    frame = study.run_study(campaign, output=output, processes=1)
    (tmp_path / "own.yaml").unlink()
    for number in (1, 8):
        scenario = load_scenario(str(write_case(f"{output}:{number}", tmp_path / f"cases_case_{number}.yaml")[0]))
        again = run_task(Task(cases[number - 1], scenario))
        row = frame.set_index("case").loc[number]
        assert {key: value for key, value in again.kpis.items() if np.isfinite(value)} == {
            key: row[key] for key in again.kpis if np.isfinite(row[key])
        }
        assert (again.is_lost, not again.missed) == (row["lost"], row["met"])
        assert scenario.name == f"cases_case_{number}"
    # kept as it was computed, and read by anyone
    pandas.testing.assert_frame_equal(pandas.read_parquet(output), frame)
    _, about = read_cases(output)
    assert about["scenario"] == "b2_calm_300"
    picture.save_picture(frame, "unit_sigma_m", tmp_path / "own.svg")
    assert "peak_period" in (tmp_path / "own.svg").read_text()


def test_a_reference_to_no_case_is_one_line(campaign, tmp_path, monkeypatch):
    monkeypatch.setattr(executors, "run_task", pretended)
    output = tmp_path / "cases.parquet"
    study.run_study(campaign, output=output, processes=1)
    with pytest.raises(ParameterError, match="has no case 9: it has 1 to 8"):
        write_case(f"{output}:9")
    with pytest.raises(ParameterError, match=r"none\.parquet: no such file"):
        write_case(f"{tmp_path}/none.parquet:1")
    broken = tmp_path / "broken.parquet"
    broken.write_bytes(b"no parquet")
    with pytest.raises(ParameterError, match="cannot be read as a table of cases"):
        write_case(f"{broken}:1")


def test_the_command_writes_table_figures_and_pictures(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(executors, "run_task", pretended)
    Path("own.yaml").write_text(TEXT.replace("seeds: 2", "seeds: 4"))
    files = ("--output", "own.parquet", "--csv", "own.csv", "--plot", "own.png", "--tornado", "own.svg")
    assert main(["campaign", "own.yaml", "--processes", "1", *files, "--json", "own.json"]) == 0
    said = capsys.readouterr().out
    assert "lost: compensation ended at 2.00 s" in said
    assert "failed: the cable parted" in said
    frame, figures = read_cases(Path("own.parquet"))[0], pandas.read_csv("own.csv")
    assert list(figures.columns) == [name for name in frame.columns if name not in ("scenario", "files")]
    np.testing.assert_allclose(figures["unit_sigma_m"], frame["unit_sigma_m"])
    assert figures["winch_controller.law"].tolist() == frame["winch_controller.law"].tolist()
    assert Path("own.png").read_bytes().startswith(b"\x89PNG")
    assert "peak_period" in Path("own.svg").read_text()
    assert len(json.loads(Path("own.json").read_text())["cases"]) == 16


def test_the_time_to_go_is_told_in_the_unit_of_a_person():
    assert time_to_go(10.0, 0.5) == "10 s to go"
    assert time_to_go(600.0, 0.5) == "10 min to go"
    assert time_to_go(7200.0, 0.25) == "6.0 h to go"


@pytest.mark.long
def test_workers_of_a_dask_scheduler_give_the_same_numbers(campaign):
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        over_dask = study.run_study(campaign, dask=cluster.scheduler_address)
    pandas.testing.assert_frame_equal(over_dask, study.run_study(campaign, processes=1))


@pytest.fixture
def workers(tmp_path: Path):
    """Start a Dask scheduler and two workers, as on machines of a cluster; yield its address and both processes."""
    pytest.importorskip("distributed")
    file, started = tmp_path / "scheduler.json", []

    def start(what: str, *arguments: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", f"distributed.cli.dask_{what}", "--scheduler-file", str(file)]
        with (tmp_path / f"{what}{len(started)}.log").open("wb") as log:
            started.append(subprocess.Popen([*command, "--no-dashboard", *arguments], stdout=log, stderr=log))
        return started[-1]

    try:
        start("scheduler", "--host", "127.0.0.1", "--port", "0")
        both = [start("worker", "--nthreads", "1", "--no-nanny", "--name", name) for name in ("first", "second")]
        while not (file.exists() and file.read_text().endswith("}")):
            assert all(process.poll() is None for process in started)
            time.sleep(0.1)
        yield json.loads(file.read_text())["address"], both
    finally:
        for process in started:
            process.kill()
            process.wait()


@pytest.mark.long
def test_a_worker_that_is_killed_midway_costs_no_case(campaign, workers):
    """What the killed one had in hand is run by the other; the table is that of one process."""
    address, (first, _) = workers
    distributed = pytest.importorskip("distributed")
    tasks, results = make_tasks(campaign, list(campaign.cases())), []
    with distributed.Client(address) as client:
        client.wait_for_workers(2, timeout=60)
        for result in executors.run_tasks(tasks, dask=address):
            if not results:
                names = {worker: facts["name"] for worker, facts in client.scheduler_info()["workers"].items()}
                in_hand = {names[worker]: len(cases) for worker, cases in client.processing().items()}
                assert in_hand["first"] > 0
                first.kill()
            results.append(result)
        assert [facts["name"] for facts in client.scheduler_info()["workers"].values()] == ["second"]
    results.sort(key=lambda result: result.case.number)
    pandas.testing.assert_frame_equal(case_frame(tasks, results), study.run_study(campaign, processes=1))


def test_a_scheduler_that_does_not_answer_is_one_line():
    pytest.importorskip("distributed")
    with pytest.raises(CommandError, match="--dask nonsense: no scheduler answers"):
        next(executors.run_tasks([], dask="nonsense"))


def test_the_baseline_beside_a_case_is_the_efficiency_of_law_industrial_in_the_same_sea(tmp_path):
    path = tmp_path / "laws.yaml"
    path.write_text(TEXT.replace("[off, mpc]", "[lqg, industrial]"))
    campaign = read_campaign(path)
    own, industrial = (
        next(case for case in campaign.cases() if case.settings["winch_controller.law"] == law)
        for law in ("lqg", "industrial")
    )
    (task,), (other,) = make_tasks(campaign, [own], has_baseline=True), make_tasks(campaign, [industrial])
    found, expected = run_task(task).kpis, run_task(other).kpis
    assert found["baseline_efficiency"] == expected["unit_efficiency"]
    assert np.isnan(expected["baseline_efficiency"])


def test_a_campaign_of_laws_that_has_the_baseline_among_them_shows_it_beside_each(tmp_path, monkeypatch):
    def efficient(task: Task) -> CaseResult:
        """Stand for a run: case k has an efficiency of k/10, and knows of no baseline."""
        return CaseResult(task.case, {"unit_efficiency": 0.1 * task.case.number})

    monkeypatch.setattr(executors, "run_task", efficient)
    path = tmp_path / "laws.yaml"
    path.write_text(TEXT.replace("[off, mpc]", "[mpc, industrial]"))
    frame = study.run_study(read_campaign(path), processes=1)
    place = {
        (row["winch_controller.law"], row["system.sea.peak_period"], row["seed"]): k for k, row in frame.iterrows()
    }
    for (_, period, seed), k in place.items():
        of_industrial = frame["unit_efficiency"][place["industrial", period, seed]]
        assert frame["baseline_efficiency"][k] == of_industrial
    assert any(heading.startswith("baseline") for heading in case_table(frame).columns)
    assert left_out(frame) == []


def test_a_campaign_without_the_baseline_says_that_it_is_left_out(campaign, monkeypatch):
    monkeypatch.setattr(executors, "run_task", lambda task: CaseResult(task.case, {"unit_efficiency": 0.9}))
    (line,) = left_out(study.run_study(campaign, processes=1))
    assert "law industrial" in line
    assert "--no-baseline" in line


def test_a_case_whose_sea_is_among_the_cases_under_the_baseline_law_is_not_run_again(tmp_path):
    path = tmp_path / "laws.yaml"
    path.write_text(TEXT.replace("[off, mpc]", "[mpc, industrial]"))
    campaign = read_campaign(path)
    tasks = make_tasks(campaign, list(campaign.cases()), has_baseline=True)
    assert {task.case.settings["winch_controller.law"] for task in tasks if task.has_baseline} == {"industrial"}


def test_a_winch_that_the_baseline_law_cannot_drive_is_one_note_for_the_study(campaign, tmp_path, monkeypatch):
    path = tmp_path / "first_order.yaml"
    path.write_text("scenario: b1_thesis\nduration: 3\nseeds: 2\nset: {all.transient: 1.0, cable_sim.segments: 2}\n")
    frame = study.run_study(read_campaign(path), output=tmp_path / "b1.parquet", processes=1, has_baseline=True)
    assert set(frame["failure"]) == {""}
    assert frame["baseline_efficiency"].isna().all()
    note = "the baseline is unknown: law industrial commands a rate: set winch.law to speed_servo"
    assert left_out(frame) == [note]
    assert left_out(read_cases(tmp_path / "b1.parquet")[0]) == [note]
    frame.loc[1, ["baseline_unknown", "baseline_efficiency"]] = "", 0.5
    assert left_out(frame) == [note.replace("is unknown", "of 1 of 2 cases is unknown; case 1")]


def test_a_baseline_that_cannot_be_computed_costs_nothing_but_itself(campaign, monkeypatch):
    def fails(scenario: object) -> None:
        raise RuntimeError("no equilibrium:\n 3 m of cable")

    monkeypatch.setattr("heave_studies.baseline.baseline_signals", fails)
    (task, *_) = make_tasks(campaign, list(campaign.cases()), has_baseline=True)
    result = run_task(task)
    assert result.failure == ""
    assert np.isfinite(result.kpis["unit_efficiency"])
    assert result.baseline_unknown == "no equilibrium: 3 m of cable"


@pytest.mark.parametrize(
    ("begun_with", "words"),
    [
        (True, "was begun without --no-baseline: leave that option out"),
        (False, "was begun with --no-baseline: give that option again"),
    ],
)
def test_a_study_goes_on_with_or_without_the_baseline_as_it_was_begun(
    campaign, tmp_path, monkeypatch, begun_with, words
):
    output = tmp_path / "cases.parquet"

    def ends_after_four(task: Task) -> CaseResult:
        if task.case.number == 5:
            raise KilledError
        return pretended(task)

    monkeypatch.setattr(executors, "run_task", ends_after_four)
    with pytest.raises(KilledError):
        study.run_study(campaign, output=output, processes=1, has_baseline=begun_with)
    kept = tmp_path.joinpath("cases.parquet.partial").read_text()
    monkeypatch.setattr(executors, "run_task", pretended)
    with pytest.raises(ParameterError, match=rf"cases\.parquet\.partial: {words}"):
        study.run_study(campaign, output=output, processes=1, has_baseline=not begun_with)
    assert tmp_path.joinpath("cases.parquet.partial").read_text() == kept
    assert len(study.run_study(campaign, output=output, processes=1, has_baseline=begun_with)) == 8
    with pytest.raises(ParameterError, match=rf"cases\.parquet: {words}"):  # complete: the same words
        study.run_study(campaign, output=output, processes=1, has_baseline=not begun_with)


def test_progress_says_that_each_case_is_run_under_the_baseline_law_too(campaign, monkeypatch, capsys):
    monkeypatch.setattr(executors, "run_task", pretended)
    monkeypatch.setattr("heave_bringup.progress.QUIET_PERIOD", 0.0)
    study.run_study(campaign, processes=1, has_baseline=True)
    first, second, *_ = capsys.readouterr().err.splitlines()
    assert "8 cases of b2_calm_300, each also under the industrial baseline (skip: --no-baseline)" in first
    assert "case 1 of 8 and its baseline, " in second
    study.run_study(campaign, processes=1)
    assert "baseline" not in capsys.readouterr().err
