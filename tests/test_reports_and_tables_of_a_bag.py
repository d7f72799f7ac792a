"""What `heave report`, `kpi` and `export` write of bags, and that none of it takes the place of something else."""

import json
import os
import resource
import shutil
import signal
import sys
from pathlib import Path

import pandas
import pytest
from heave_bags import Bag
from heave_bags.analyse import kpi_set
from heave_bags.analyse.read_run import read_run
from heave_bags.mcap.loss import Loss, remarks
from heave_bringup.cli import main

sys.path.insert(0, str(Path(__file__).parents[1] / "bags" / "test"))

from made_up_run import MadeUpRun, write_run

from tests import browser


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Return a folder with the folders of two runs, each with its bag and its report."""
    folder = tmp_path_factory.mktemp("runs")
    for name, unit in (("one", 0.05), ("two", 0.2)):
        write_run(folder / name / "bag", MadeUpRun(unit=unit))
        (folder / name / "report.html").write_text(f"the report of run {name}")
    return folder


def test_a_bag_is_found_in_the_folder_of_its_run(runs):
    assert Bag(runs / "one").path == runs / "one" / "bag"
    assert Bag(runs / "one" / "bag").message_count == Bag(runs / "one").message_count > 0


def test_a_comparison_leaves_the_reports_of_its_runs_as_they_are(runs, capsys):
    for number in (1, 2):
        assert main(["report", str(runs / "one"), str(runs / "two"), "--json", "-"]) == 0
        written = Path(json.loads(capsys.readouterr().out)["report"])
        assert written == runs / f"comparison-{number:03d}.html"
        assert "load heave of all runs" in written.read_text().lower()
    for name in ("one", "two"):
        assert (runs / name / "report.html").read_text() == f"the report of run {name}"
    output = str(runs / "two" / "report.html")
    assert main(["report", str(runs / "one"), str(runs / "two" / "bag"), "--output", output]) == 2
    assert "is the report of one of the runs" in capsys.readouterr().err


def test_a_summary_is_eight_figures_at_most_and_full_has_all(runs, capsys):
    titles = [definition.title for definition in kpi_set.KPI_DEFINITIONS]

    def shown(*options: str) -> list[str]:
        assert main(["report", str(runs / "one"), "--output", str(runs / "x.html"), *options]) == 0
        lines = capsys.readouterr().out.splitlines()
        return [title for title in titles if any(line.startswith(f"{title}  ") for line in lines)]

    few, all_ = shown(), shown("--full")
    assert 6 <= len(few) <= 8
    assert few[:3] == [
        "load heave, standard deviation",
        "load heave with the winch locked, standard deviation",
        "efficiency at the load",
    ]
    assert set(few) < set(all_)
    assert len(all_) > 40


def test_a_pdf_without_a_browser_is_refused_in_a_line_before_any_work(runs, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("heave_bags.report.paper.PLACES", ())
    monkeypatch.setenv("PATH", str(tmp_path))
    assert main(["report", str(runs / "one"), "--output", str(tmp_path / "x.html"), "--pdf"]) != 0
    said = capsys.readouterr().err
    assert "no Chromium, Chrome or Edge is installed here" in said
    assert said.count("\n") == 1
    assert not (tmp_path / "x.html").exists()


@browser.NEEDED
def test_a_report_brings_its_pdf_with_it(runs, tmp_path, capsys):
    assert main(["report", str(runs / "one"), "--output", str(tmp_path / "x.html"), "--pdf", "--json", "-"]) == 0
    pdf = Path(json.loads(capsys.readouterr().out)["pdf"])
    assert pdf == tmp_path / "x.pdf"
    assert pdf.read_bytes().startswith(b"%PDF-")


def test_an_export_is_one_table_of_signals_in_each_form(runs, tmp_path, capsys):
    files = ["--table", str(tmp_path / "x.csv"), str(tmp_path / "x.parquet")]
    assert main(["export", str(runs / "one"), *files, "--period", "0.1", "--json", "-"]) == 0
    result = json.loads(capsys.readouterr().out)
    text, table = pandas.read_csv(tmp_path / "x.csv"), pandas.read_parquet(tmp_path / "x.parquet")
    assert len(text) == len(table) == result["rows"]
    assert ["time_s", *result["columns"]] == list(table.columns) == list(text.columns)
    assert not text.iloc[[0, -1]].isna().any(axis=None), "begins and ends with a whole row"
    named = pandas.read_csv(tmp_path / "x_columns.csv").set_index("column")
    assert list(named.index) == list(text.columns)
    assert named.loc["payout_rate_mps", "unit"] == "m/s"
    assert "positive pays out" in named.loc["payout_rate_mps", "meaning"]
    assert text["payout_m"].to_numpy() == pytest.approx(table["payout_m"].to_numpy(), rel=1e-8, nan_ok=True)
    assert main(["export", str(runs / "one"), "--topics", "winch/state", "--table", str(tmp_path / "w.csv")]) == 0
    assert "winch/state.payout_rate" in pandas.read_csv(tmp_path / "w.csv").columns
    named = pandas.read_csv(tmp_path / "w_columns.csv").set_index("column")
    assert named.loc["winch/state.payout_rate", "unit"] == "m/s", "as the definition of the message says"


@pytest.mark.parametrize(
    ("arguments", "status", "words"),
    [
        (["--table", "x.txt"], 2, "--table x.txt: must end in .csv or .parquet or .xlsx"),
        (["--table", "no/x.csv"], 2, "there is no folder no"),
        (["--table", "x.csv", "--period", "0"], 2, "--period 0: must be at least 0.0001 [s]"),
        (["--table", "x.csv", "--period", "nan"], 2, "--period nan: must be"),
        (["--table", "x.csv", "--topics", "winch/stat"], 1, "no topic winch/stat; it has"),
    ],
)
def test_a_wrong_export_is_one_line_and_no_file(runs, tmp_path, monkeypatch, capsys, arguments, status, words):
    monkeypatch.chdir(tmp_path)
    assert main(["export", str(runs / "one"), *arguments]) == status
    said = capsys.readouterr().err.splitlines()[-1]
    assert words in said
    assert list(tmp_path.iterdir()) == []


def test_what_a_bag_lost_is_on_the_screen_of_every_command_that_reads_it(runs, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    shutil.copytree(runs / "one" / "bag", "cut/bag")
    (file,) = Path("cut/bag").glob("*.mcap")
    os.truncate(file, file.stat().st_size * 7 // 10)
    (loss,) = read_run("cut").losses
    assert loss.messages > 0
    for command in (["report"], ["report", "--full"], ["kpi"], ["export", "--table", "x.csv"]):
        assert main([command[0], "cut", *command[1:]]) == 0
        screen = "".join(capsys.readouterr())
        assert screen.count(str(loss)) == 1, command
        heads = [line for line in screen.splitlines() if "verdict" in line]
        assert all(line.endswith("; not all of the bag could be read") for line in heads), heads
        assert len(heads) == (command[0] == "report")
    assert main(["repair", "cut", "--output", "saved"]) == 0
    assert str(loss) in capsys.readouterr().out


def test_of_many_losses_the_largest_are_named_and_the_others_counted():
    losses = [Loss(Path("x.mcap"), 10 * number, "bad", 0, 1, number) for number in range(1, 41)]
    lines = remarks([], losses)
    assert [line.split()[-3] for line in lines] == ["38", "39", "40", str(sum(range(1, 38)))]
    assert "37 more places" in lines[-1]
    assert len(remarks([], losses[:3])) == 3
    lines = remarks(["note"], [*losses, Loss(Path("x.mcap"), None, "cut")])
    assert lines[0] == "note"
    assert "an unknown number of" in lines[3], "it may be the largest"


def test_a_full_disk_leaves_no_file_and_is_one_line(runs, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    limit = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    bag = str(runs / "one")
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, limit[1]))  # as a disk with no more room
        for command in (
            ["report", bag, "--output", "x.html"],
            ["kpi", bag, "--json", "x.json"],
            ["kpi", bag, "--table", "x.csv"],
            ["export", bag, "--table", "x.parquet"],
        ):
            assert main(command) == 1
            said = capsys.readouterr().err.splitlines()[-1]
            assert f"{command[-1]}: " in said
            assert "File too large" in said
            assert list(tmp_path.iterdir()) == [], command
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limit)
        signal.signal(signal.SIGXFSZ, handler)
