"""The engine of studies: ended and begun again, failed cases, workers, table, page, a row that repeats a case."""

from __future__ import annotations

import contextlib
import io
import json
import os
import random
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from unittest.mock import MagicMock

import numpy as np
import pandas
import pytest
from heave_bags.analyse import kpi_set
from heave_bringup.cli import main
from heave_bringup.errors import CommandError
from heave_bringup.progress import ProgressLine, time_to_go
from heave_bringup.scenarios import load_scenario
from heave_node.parameters import ParameterError
from heave_studies.operability.limits import HEIGHT
from heave_studies.study import cases
from heave_studies.study.case_file import CASE, SCENARIO, read_cases, write_case
from heave_studies.study.cases import Cases
from heave_studies.study.cost import COST, LIFTS, PARTS, cost_rows, write_cost
from heave_studies.study.engine import JOURNAL, SETTLED, TABLE, run_study
from heave_studies.study.runs import CaseResult, Task, run_task
from heave_studies.study.study_file import read_study
from heave_studies.study.summary import bootstrap, case_table, remarks, summarise, summary_rows, wilson
from heave_studies.study.workers import DIED, Job, Plain, workers
from rich.console import Console
from scipy import stats

CABLE = "system.cable.breaking_force=200000"
TEXT = """
scenario: b2_calm_300
duration: 3
seeds: 2
set: {all.transient: 1.0, wave_vessel.ramp: 0.5, cable_sim.segments: 2}
wanted: {unit_sigma_m: "<= 0.5"}
vary: {winch_controller.law: [off, mpc], system.sea.peak_period: [6.0, 7.0]}
"""


@pytest.fixture
def kind(tmp_path: Path, monkeypatch) -> Cases:
    monkeypatch.chdir(tmp_path)
    Path("own.yaml").write_text(TEXT)
    return Cases(read_study(Path("own.yaml")))


def pretended(task: Task) -> CaseResult:
    """Stand for a run: figures that depend on the case alone; case 3 cannot be run, case 5 is lost."""
    if task.case.number == 3:
        return CaseResult(task.case, failure="the cable parted")
    kpis = dict.fromkeys(kpi_set.DEFINITION_OF, 0.1 * task.case.number) | {"snaps": 0.0, "uncompensated_snaps": 0.0}
    return CaseResult(task.case, kpis, "", 0.5, "compensation ended at 2.00 s" if task.case.number == 5 else "")


class KilledError(Exception):
    """What ends a study in the middle."""


def test_a_study_that_was_ended_goes_on_where_it_was_and_gives_the_same_file(kind, monkeypatch, capsys):
    monkeypatch.setattr(cases, "run_task", pretended)
    whole, resumed = Path("whole"), Path("resumed")
    run_study(kind, whole, processes=1)
    run: list[int] = []

    def ends_after_four(task: Task) -> CaseResult:
        run.append(task.case.number)
        if task.case.number == 5 and len(run) == 5:
            raise KilledError
        return pretended(task)

    monkeypatch.setattr(cases, "run_task", ends_after_four)
    with pytest.raises(KilledError):
        run_study(kind, resumed, processes=1)
    assert "4 cases are kept in resumed/journal.jsonl: the same command goes on there" in capsys.readouterr().err
    assert not (resumed / TABLE).exists()
    journal = resumed / JOURNAL
    journal.write_text(journal.read_text() + '[5, {"kp')  # killed within a line
    run_study(kind, resumed, processes=1)
    assert run == [1, 2, 3, 4, 5, 5, 6, 7, 8]
    assert (resumed / TABLE).read_bytes() == (whole / TABLE).read_bytes()
    assert not journal.exists()
    assert len(run_study(kind, resumed, processes=1)[0]) == 8
    assert len(run) == 9  # nothing was left to be run


def test_the_results_of_another_study_are_not_taken(kind, monkeypatch):
    monkeypatch.setattr(cases, "run_task", pretended)
    Path("out").mkdir()
    Path("out", JOURNAL).write_text('{"digest": "other"}\n')
    with pytest.raises(ParameterError, match=r"out/journal\.jsonl: holds results of another study"):
        run_study(kind, Path("out"), processes=1)
    run_study(kind, Path("whole"), processes=1)
    Path("own.yaml").write_text(TEXT + "adviser: false\n")
    with pytest.raises(ParameterError, match=r"whole/table\.parquet: holds results of another study"):
        run_study(Cases(read_study(Path("own.yaml"))), Path("whole"), processes=1)


def test_a_failed_case_is_a_row_and_stops_no_other(kind, monkeypatch):
    monkeypatch.setattr(cases, "run_task", pretended)
    frame, _ = run_study(kind, processes=1)
    assert len(frame) == 8
    assert frame.set_index("case")["failure"].to_dict()[3] == "the cable parted"
    assert np.isnan(frame.set_index("case")["unit_sigma_m"].to_dict()[3])
    assert not frame.set_index("case")["met"].to_dict()[3]
    summary = summarise(frame)
    assert (summary["cases"], summary["failed"], summary["judged"], summary["lost"]) == (8, 1, 7, 1)
    head, rows = summary_rows(frame)
    assert head == ["all cases", "off", "mpc", "unit"], "figures over several laws together would mean nothing"
    assert ["cases that met all criteria: share, 90 % confidence", "53 to 100", "60 to 100", "%"] in rows
    assert remarks(frame) == ["case 3: failed: the cable parted", "case 5: lost: compensation ended at 2.00 s"]
    many = pandas.concat([frame] * 30, ignore_index=True)
    assert remarks(many)[-1] == "and 40 cases more, see table.csv"


def test_ninetieth_percentiles_are_stated_of_ten_cases_and_more(kind, monkeypatch):
    monkeypatch.setattr(cases, "run_task", pretended)
    few = run_study(kind, processes=1)[0]
    assert "unit_sigma_m_p90" not in summarise(few)
    assert not [row for row in summary_rows(few)[1] if "90th percentile" in row[0]]
    many = pandas.concat([few] * 3, ignore_index=True)
    assert summarise(many)["unit_sigma_m_p90"] == pytest.approx(np.percentile(many["unit_sigma_m"].dropna(), 90))


def test_the_command_says_what_was_run_and_names_its_worst_case_with_unit_and_file(kind, monkeypatch, capsys):
    """Case 8 has the largest standard deviation, 0.8 m; each case stands on the progress line once."""
    monkeypatch.setattr(cases, "run_task", pretended)
    assert main(["study", "own.yaml", "--processes", "1", "--output", "out", "--set", CABLE]) == 0
    said = capsys.readouterr()
    assert "worst case: 8, load heave, standard deviation 80.00 cm" in said.out
    assert "heave study --case out/table.parquet:8" in said.out
    assert "load cm" in said.out
    page = Path("out", "page.html").read_text()
    for words in ("b2_calm_300", "t in air", "law off, mpc", "3 s each, figures from 1 s on; seeds 1, 2"):
        assert words in page
    assert "Safety factor" in page or "safety factor" in page, "the rope is judged in every case"
    assert "at least 2.5" in page


def test_a_screening_settles_the_cases_that_it_covers(monkeypatch, tmp_path):
    shown: list[str] = []
    monkeypatch.setattr(ProgressLine, "show", lambda _, text, share: shown.append(text))
    monkeypatch.setattr(cases, "screen", screened)
    (tmp_path / "own.yaml").write_text(TEXT + "screening: true\n")
    kind = Cases(read_study(tmp_path / "own.yaml"))
    run_study(kind, processes=1)
    assert shown[0].startswith("8 cases of own")
    assert [text.split(" cases")[0] for text in shown[1:]] == ["2 of 8", "4 of 8", "6 of 8", "8 of 8"]
    assert "and 1 more seed" in shown[1]


def screened(tasks):
    lifts = {str(one.case.number): {**pretended(one).to_plain(), "is_screened": True} for one in tasks}
    return {LIFTS: lifts, SETTLED: len(lifts)}


@pytest.mark.parametrize("text", ["scenario: [1,2\n x", "scenario: \tb2\n\t- x", "- 1", "\x00", "a: *b"])
def test_a_file_that_is_no_study_is_one_line_and_exit_status_2(text, tmp_path, capsys):
    path = tmp_path / "bad.yaml"
    path.write_text(text)
    for more in ([], ["--vary", "winch_controller.law=off,mpc"]):
        assert main(["study", str(path), *more]) == 2
        said = capsys.readouterr().err
        assert said.count("\n") == 1
        assert "bad.yaml" in said


def test_widths_are_wilson_s_and_of_the_bootstrap():
    """Wilson's interval as scipy has it; of a mean the bootstrap gives about that of Student's t."""
    expected = stats.binomtest(7, 10).proportion_ci(0.9, "wilson")
    assert wilson(7, 10) == pytest.approx((expected.low, expected.high))
    values = np.random.default_rng(1).normal(size=200)
    ends = stats.t.interval(0.9, 199, values.mean(), stats.sem(values))
    assert bootstrap(values, lambda sample: float(sample.mean())) == pytest.approx(ends, abs=0.03)


@pytest.mark.parametrize("columns", [60, 80, 100])
def test_the_table_of_cases_fits_the_terminal_and_its_laws_stay_whole(kind, monkeypatch, columns):
    monkeypatch.setattr(cases, "run_task", pretended)
    table = case_table(run_study(kind, processes=1)[0])
    console = Console(width=columns, file=io.StringIO())
    shown, line = table.fitted(console)
    console.print(shown)
    lines = console.file.getvalue().splitlines()
    assert max(map(len, lines)) <= columns
    assert sum("law=mpc" in text for text in lines) == 4
    assert line.startswith("not shown for want of room: ")


def test_the_command_varies_a_scenario_and_writes_table_csv_and_page(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(cases, "run_task", pretended)
    vary = ["--vary", "winch_controller.law=off,lqg,mpc", "--vary", "system.unit.added_mass=[1.0, 1.0, 1.0],[2, 2, 2]"]
    files = ["--output", "out", "--json", "own.json", "--processes", "1"]
    assert main(["study", "b2_calm_300", *vary, "--seeds", "2", "--duration", "200", *files]) == 0
    said = capsys.readouterr().out
    assert "lost: compensation ended at 2.00 s" in said
    assert "worst case: 12, " in said
    frame, figures = read_cases(Path("out", TABLE))[0], pandas.read_csv("out/table.csv")
    assert set(frame["winch_controller.law"]) == {"off", "lqg", "mpc"}, "off is a law, not False"
    np.testing.assert_allclose(figures["unit_sigma_m"], frame["unit_sigma_m"])
    page = Path("out", "page.html").read_text()
    assert "heave study --case out/table.parquet:CASE" in page
    assert "failed: the cable parted" in page
    result = json.loads(Path("own.json").read_text())
    assert (len(result["cases"]), result["judged"]) == (12, 11)
    assert main(["study", "b2_calm_300", *vary, "--seeds", "2", "--duration", "200", "--check"]) == 0
    assert "12 cases, no errors found" in capsys.readouterr().out


def test_scenarios_themselves_can_be_varied(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("own.yaml").write_text("scenario: b2_calm_300\nvary: {base: [b2_calm_300, b3_deep_900]}\n")
    lengths = [task.scenario.parameters["cable_sim"].length for task in Cases(read_study(Path("own.yaml")))._first]
    assert lengths == [300.0, 900.0]


@pytest.mark.parametrize(
    ("failure", "words"),
    [
        ("its worker was lost: Error during deserialization of the task graph", "the workers need this suite"),
        ("the cable parted", "nothing was judged in 8 cases; the first: the cable parted"),
    ],
)
def test_a_study_of_which_no_case_ran_ends_with_status_1(kind, monkeypatch, capsys, failure, words):
    monkeypatch.setattr(cases, "run_task", lambda task: CaseResult(task.case, failure=failure))
    assert main(["study", "own.yaml", "--processes", "1"]) == 1
    assert words in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["b2_calm_300", "--vary", "winch_controller.law"], "must be NODE.PARAM=VALUE,VALUE,..."),
        (["b2_calm_300", "--vary", "law=off"], "--vary law=off: law is not a parameter"),
        (["b2_calm_300", "--vary", "winch_controller.lw=off"], "--vary: winch_controller: there is no parameter lw"),
        (["b2_calm_300", "--vary", "winch_controller.law=sail"], "--vary: winch_controller: law = 'sail' is not"),
        (["b2_calm_300", "--vary", "system.length=-3"], "--vary: system.length = -3.0 is not allowed for"),
        (["b2", "--vary", "winch_controller.law=off"], "b2: no such scenario"),
        (["b2_calm_300", "--vary", "all.seed=1", "--vary", "all.seed=2"], "--vary all.seed: stands twice"),
        (["seeds", "--seeds", "0"], "--seeds 0: must be at least 1"),
        (["seeds", "--set", "winch_controller.law"], "--set winch_controller.law: must be NODE.PARAM=VALUE"),
        (["seeds", "--ask", "record"], "--ask record: must be KEY=VALUE"),
        (["seeds", "--ask", "recrod=x"], "ask: there is no recrod; known: figure"),
        (["seeds", "--ask", "answer=limts"], "ask: answer = limts: must be one of cases, limits"),
        (["seeds", "--require", "sgima<3"], "sgima is not a figure of merit"),
        (["few", "--seeds", "3"], "--seeds: is not for few: write it into its file"),
        (["no_such_study"], "no_such_study: no such study or file; shipped are: ablation"),
        ([], "name a study file"),
        (["few", "--ask", "without=gurad"], "there is no part 'gurad'"),
        (["few", "--ask", "seed=x"], "ask: seed = 'x'"),
        (["few", "--ask", "only=[-1]"], "ask: only = -1"),
        (["operability", "--vary", f"{HEIGHT}=2"], f"{HEIGHT}: needs at least two values above 0 that rise"),
        (["lift", "--ask", "alpha=none.csv"], "ask: alpha = none.csv: must be a number"),
        (["lift", "--ask", "alpha=2"], "ask: alpha = 2: must be above 0, and at most 1"),
        (["operability", "--ask", "within=0"], "ask: within = 0: must be a width above 0"),
        (["sizing", "b9_model_error"], "no criteria: give the study some (wanted), or --require"),
        (["sizing", "--ask", "speed=-1"], "ask: speed = -1: must be a number above 0 [m/s]"),
        (["sizing", "--ask", "delay=.nan"], "ask: delay = nan: must be a number above 0 [s]"),
        (["sizing", "--set", "virtual_winch.drive=electric"], "its limits follow from its physics"),
    ],
)
def test_what_is_wrong_with_a_command_line_is_one_line_and_status_2(arguments, words, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["study", *arguments]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert said.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_a_row_alone_repeats_its_case_and_gives_its_figures(kind):
    run_study(kind, Path("out"), processes=1)
    frame, about = read_cases(Path("out", TABLE))
    Path("own.yaml").unlink()
    for number in (1, 8):
        scenario = load_scenario(str(write_case(f"out/{TABLE}:{number}", Path(f"case_{number}.yaml"))))
        again = run_task(Task(kind._first[number - 1].case, scenario))
        row = frame.set_index("case").loc[number]
        assert {key: value for key, value in again.kpis.items() if np.isfinite(value)} == {
            key: row[key] for key in again.kpis if np.isfinite(row[key])
        }
        assert (again.is_lost, not again.missed) == (row["lost"], row["met"])
    assert about["study"] == "own"
    with pytest.raises(ParameterError, match="has no case 9: it has 1 to 8"):
        write_case(f"out/{TABLE}:9")


@dataclass
class Numbers:
    """A kind of study whose jobs square numbers; the job of 3 ends its process."""

    name: str = "numbers"
    identity: str = "numbers"
    size: int = 8
    is_local: bool = False
    is_open: bool = False
    files: Mapping[str, object] = field(default_factory=dict)

    def rounds(self, _: Mapping[int, Plain]) -> Iterator[list[Job]]:
        yield [Job(number, str(number), partial(square, number)) for number in range(1, 9)]

    def frame(self, results: Mapping[int, Plain]) -> pandas.DataFrame:
        rows = [{CASE: n, SCENARIO: "", **result} for n, result in sorted(results.items())]
        return pandas.DataFrame(rows)


def square(number: int) -> Plain:
    if number == 3:
        os.kill(os.getpid(), 9)
    return {"square": number**2, "process": os.getpid()}


def test_a_process_that_dies_costs_its_own_job_only():
    frame, _ = run_study(Numbers(), processes=2)  # type: ignore[arg-type]
    failures = frame.set_index(CASE)["failure"].dropna().to_dict()
    assert failures == {3: DIED}
    assert frame["square"].dropna().tolist() == [1, 4, 16, 25, 36, 49, 64]
    assert os.getpid() not in set(frame["process"])


def test_a_scheduler_that_does_not_answer_is_one_line():
    with pytest.raises(CommandError, match="--dask nonsense: no scheduler answers"), workers(address="nonsense"):
        pass


@pytest.mark.parametrize(
    ("call", "trouble", "words"),
    [
        ("run", ModuleNotFoundError("No module named 'heave_studies'"), "a worker lacks the suite"),
        ("wait_for_workers", TimeoutError(), "the scheduler has no worker: start one"),
    ],
)
def test_workers_that_run_nothing_are_one_line(call, trouble, words, monkeypatch):
    """Else one would end with the first job, which it cannot read, and nothing would come from it for ever."""
    import distributed  # noqa: PLC0415 - slow

    client = MagicMock()
    getattr(client.return_value, call).side_effect = trouble
    monkeypatch.setattr(distributed, "Client", client)
    with pytest.raises(CommandError, match=f"--dask tcp://there:1: {words}"), workers(0, "tcp://there:1"):
        pass


def test_a_worker_that_joins_late_without_the_suite_gets_no_job():
    """One has it, and says so also when it joins after the study has begun; the other one is left idle."""
    import distributed  # noqa: PLC0415 - slow

    options = {"processes": False, "threads_per_worker": 1, "dashboard_address": None}
    with distributed.LocalCluster(n_workers=1, **options) as cluster, workers(0, cluster.scheduler_address) as run:
        cluster.scale(2)
        while len(cluster.scheduler.workers) < 2:
            time.sleep(0.05)
        late = [worker for worker in cluster.workers.values() if worker.name != 0]
        for worker in late:
            cluster.sync(worker.set_resources, heave=0)  # as where the suite cannot be imported
        jobs = [Job(number, str(number), threading.get_ident) for number in range(6)]
        assert late
        assert len({result for _, result in run(jobs)}) == 1


@pytest.mark.slow
def test_a_study_that_is_killed_and_goes_on_with_two_workers_elsewhere_gives_the_same_file(kind):
    """Killed with its two workers at a random moment after its first result; then run on by a scheduler's two."""
    import distributed  # noqa: PLC0415 - slow

    run_study(kind, Path("whole"), processes=1)
    command = [sys.executable, "-m", "heave_bringup.cli", "study", "own.yaml", "--processes", "2", "--output", "parts"]
    study = subprocess.Popen(command, start_new_session=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    journal, table = Path("parts", JOURNAL), Path("parts", TABLE)
    while study.poll() is None and not (journal.exists() and journal.read_text().count("\n") > 1):
        time.sleep(0.02)
    time.sleep(random.uniform(0.0, 2.0))
    with contextlib.suppress(ProcessLookupError):  # it may have come to its end
        os.killpg(study.pid, signal.SIGKILL)
    study.wait()
    assert journal.exists() or table.exists()
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        run_study(kind, Path("parts"), dask=cluster.scheduler_address)
    assert table.read_bytes() == Path("whole", TABLE).read_bytes()


UNTIL = """
scenario: b2_calm_300
duration: 3
set: {all.transient: 1.0}
vary: {winch_controller.law: [lqg, mpc]}
until: {figure: unit_sigma_m, width: 10 %, most: 40}
"""


def scattered(task: Task) -> CaseResult:
    """Stand for a run whose figure scatters about 1 m: by 1 % under lqg, by 10 % under mpc."""
    spread = 0.01 if task.case.settings["winch_controller.law"] == "lqg" else 0.1
    value = 1.0 + spread * float(np.random.default_rng(task.case.seed).standard_normal())
    kpis = dict.fromkeys(kpi_set.DEFINITION_OF, value) | {"snaps": 0.0, "uncompensated_snaps": 0.0}
    return CaseResult(task.case, kpis, "", 0.5)


def test_seeds_are_added_until_the_interval_of_the_mean_is_narrow(kind, monkeypatch):
    """Width of Student's interval: 2 t s / sqrt(n), so about (2 * 1.7 * 0.1 / 0.1)^2 = 11 seeds under mpc."""
    monkeypatch.setattr(cases, "run_task", scattered)
    Path("own.yaml").write_text(UNTIL)
    study = read_study(Path("own.yaml"))
    frame, _ = run_study(Cases(study), Path("out"), processes=1)
    counts = frame.groupby("winch_controller.law").size().to_dict()
    assert counts["lqg"] <= 4
    assert 8 <= counts["mpc"] < 40
    for _, part in frame.groupby("winch_controller.law"):
        low, high = stats.t.interval(0.9, len(part) - 1, part["unit_sigma_m"].mean(), stats.sem(part["unit_sigma_m"]))
        assert high - low <= 0.1 * part["unit_sigma_m"].mean()
        assert sorted(part["seed"]) == list(range(1, len(part) + 1))
    assert "at most 10 % of it wide in 2 of 2 combinations" in study.refinement.words(frame)
    assert len(frame) <= Cases(study).size == 80


def test_seeds_are_added_until_a_share_is_known_or_there_are_most(kind, monkeypatch):
    """Wilson's interval of 40 of 40 is [0.937, 1]: wider than 0.01, narrower than 0.1."""
    monkeypatch.setattr(cases, "run_task", scattered)
    for width, least, most in ((0.1, 20, 39), (0.01, 40, 40)):
        Path("own.yaml").write_text(UNTIL.replace("unit_sigma_m, width: 10 %", f"met, width: {width}"))
        frame, _ = run_study(Cases(read_study(Path("own.yaml"))), processes=1)
        assert all(least <= count <= most for count in frame.groupby("winch_controller.law").size())


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("until: {figure: sgima, width: 1}", "figure = 'sgima': must be a figure of merit, or met"),
        ("until: {figure: met, width: 0 %}", "width = '0 %': must be above 0"),
        ("until: {figure: met, width: 10 %, most: 1}", "most = 1: must be a number of seeds"),
        (
            "until: {figure: met, width: 1}\nsearch: {figure: met}\ndraw: {count: 9, choose: {all.seed: [1, 2]}}",
            "until: is not for a search",
        ),
    ],
)
def test_what_is_wrong_with_a_width_is_one_line(kind, text, words):
    Path("own.yaml").write_text(f"scenario: b2_calm_300\n{text}\n")
    with pytest.raises(ParameterError, match=words):
        read_study(Path("own.yaml"))


def test_what_a_case_costs_is_its_own_cost_whether_it_was_screened_or_not(tmp_path):
    cost = dict.fromkeys(PARTS, 0.0)
    screened = {LIFTS: {"1": {COST: cost | {"start": 3.0}}, "2": {"flag": "slack"}}}
    write_cost({-1: screened, 2: {COST: cost | {"sea": 1.0}}}, tmp_path)
    assert pandas.read_csv(tmp_path / "cost.csv")[["case", "start", "sea"]].values.tolist() == [[1, 3, 0], [2, 0, 1]]
    shown = {name: (seconds, share) for name, seconds, share in cost_rows(tmp_path)}
    assert (shown["start"], shown["sea"], shown["all"]) == (("1.500", "75"), ("0.500", "25"), ("2.000", "100"))


def test_the_page_has_title_question_criteria_units_and_what_a_case_costs(kind, capsys):
    Path("own.yaml").write_text("# Which law?\n" + TEXT.replace("mpc]", "lqg]").replace("[6.0, 7.0]", "[6.0]"))
    assert main(["study", "own.yaml", "--processes", "1", "--json", "own.json"]) == 0
    page = Path("studies", "own", "page.html").read_text()
    for words in (
        "<h1>own</h1>",
        "Which law?",
        "<h2>Criteria</h2>",
        "at most 50 cm",
        "seed=1 law=off sea.peak_period=6",
        "What a case costs",
    ):
        assert words in page, words
    assert "processor time [s]" in capsys.readouterr().out
    costs = pandas.read_csv(Path("studies", "own", "cost.csv"))
    assert (costs[["start", "sea", "plant", "winch", "controller", "adviser"]] > 0.0).all(axis=None)
    assert set(json.loads(Path("own.json").read_text())["cost_s"]) == {*costs.columns[1:], "all"}


def test_the_time_to_go_is_told_in_the_unit_of_a_person():
    assert time_to_go(10.0, 0.5) == "10 s to go"
    assert time_to_go(600.0, 0.5) == "10 min to go"
    assert time_to_go(7200.0, 0.25) == "6.0 h to go"
