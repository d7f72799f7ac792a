"""`heave benchmark`: the README's example runs, results can be compared, and mistakes are refused in one line."""

from __future__ import annotations

import json
import re
from importlib import resources
from pathlib import Path

import numpy as np
import pytest
from heave_bringup.benchmark.entrants.table import SHIPPED, Named
from heave_bringup.benchmark.records import find_record, read_record, records_folder
from heave_bringup.benchmark.run import all_cases
from heave_bringup.parser import make_parser
from heave_node.parameters import ParameterError
from scipy.io import savemat

README = Path(str(resources.files("heave_bringup"))) / "benchmark" / "README.md"
QUICK = ("--cases", "u2_hold", "--seeds", "2", "--duration", "75", "--processes", "1")


def heave_benchmark(*arguments: str) -> None:
    options = make_parser().parse_args(["benchmark", *arguments])
    options.execute(options)


@pytest.fixture
def entrant(tmp_path: Path) -> str:
    """The README's example, as a user would write it to a file."""
    blocks = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), flags=re.DOTALL)
    (example,) = (block for block in blocks if "class MyController" in block)
    assert len(example.splitlines()) < 40
    path = tmp_path / "my_controller.py"
    path.write_text(example, encoding="utf-8")
    return f"{path}:MyController"


def test_example_of_the_readme_runs_and_compensates(entrant: str, capsys: pytest.CaptureFixture[str]) -> None:
    heave_benchmark("run", entrant, "locked", *QUICK, "--json", "-")
    result = json.loads(capsys.readouterr().out)
    mine, locked = result["summary"]
    assert (mine["entrant"], locked["entrant"]) == ("my_controller.py:MyController", "locked")
    assert mine["ratio"] < 0.2
    assert locked["ratio"] == pytest.approx(1.0, rel=0.01)
    # the same seas for both
    figures = {(run["entrant"], run["seed"]): run["figures"]["uncompensated_sigma_m"] for run in result["runs"]}
    assert figures[("locked", 1)] == figures[("my_controller.py:MyController", 1)] != figures[("locked", 2)]


def test_digests_tell_equal_results_and_equal_problems(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def result(*arguments: str) -> dict[str, str]:
        heave_benchmark("run", *arguments, "--cases", "u2_hold", "--seeds", "1", "--processes", "1", "--json", "-")
        return json.loads(capsys.readouterr().out)

    one, again = result("locked", "--duration", "70"), result("locked", "--duration", "70")
    assert one == again
    other = result("industrial", "--duration", "70")
    assert other["problem_digest"] == one["problem_digest"]
    assert other["result_digest"] != one["result_digest"]
    assert result("locked", "--duration", "71")["problem_digest"] != one["problem_digest"]


def test_an_entrant_that_fails_is_named_and_the_others_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "bad.py"
    path.write_text(
        "class Bad:\n    def __init__(self, facts):\n        pass\n    def step(self, m):\n        return 1 / 0\n"
    )
    heave_benchmark("run", f"{path}:Bad", "locked", *QUICK)
    said = capsys.readouterr().out
    assert "ZeroDivisionError: division by zero" in said
    bad, locked = (next(line for line in said.splitlines() if name in line) for name in ("bad.py:Bad", "locked"))
    assert bad.split()[-1] == "cm"  # of the tolerance, shown once for the case
    assert " 2  tolerance 4 cm" in bad  # both seeds lost
    assert "100.00" not in locked
    assert locked.split()[4] in ("0.00", "-0.00")  # efficiency of a locked winch


@pytest.mark.parametrize(
    ("step", "words"),
    [
        ("def step(self, m):\n        return 0.3", "TypeError: step must return a Command; it returned float"),
        ("def steps(self, m):\n        pass", "TypeError: Mine has no method step(measurement)"),
    ],
)
def test_what_a_stranger_gets_wrong_in_a_controller_is_told_in_words(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], step: str, words: str
) -> None:
    path = tmp_path / "mine.py"
    path.write_text(f"class Mine:\n    def __init__(self, facts):\n        pass\n    {step}\n")
    heave_benchmark("run", f"{path}:Mine", "--cases", "u2_hold", "--seeds", "1", "--duration", "61", "--processes", "1")
    assert words in capsys.readouterr().out


def test_efficiency_of_the_industrial_baseline_stands_beside_that_of_every_entrant(
    capsys: pytest.CaptureFixture[str],
) -> None:
    heave_benchmark("run", "locked", "industrial", *QUICK)
    rows = capsys.readouterr().out.splitlines()
    heads = rows[0].split("  ")
    assert {"effic. %", "baseline %"} <= {head.strip() for head in heads}
    assert not any(row.startswith("left out") for row in rows)
    locked = next(row for row in rows if " locked " in row).split()
    industrial = next(row for row in rows if " industrial " in row).split()
    # case, entrant, seeds, off, rms, efficiency, baseline; the second entrant's row does not repeat the case
    assert locked[6] == industrial[5] == industrial[4]
    assert float(industrial[4]) > 80.0


def test_a_table_without_the_industrial_baseline_says_how_to_have_it(capsys: pytest.CaptureFixture[str]) -> None:
    heave_benchmark("run", "locked", *QUICK)
    assert "left out: the efficiency of law industrial (name industrial among the entrants)" in capsys.readouterr().out


def test_list_names_every_case_and_entrant(capsys: pytest.CaptureFixture[str]) -> None:
    heave_benchmark("list")
    said = capsys.readouterr().out
    for name in (*all_cases(None), *SHIPPED):
        assert f"  {name} " in said


def test_every_case_of_the_table_in_the_readme_exists() -> None:
    text = README.read_text(encoding="utf-8")
    for name in all_cases(None):
        assert name in text or name.split("_")[0] in ("b2", "b3", "b4", "b5", "b6", "b7", "b8", "b9", "b10", "z")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run"], "heave benchmark run: name at least one ENTRANT"),
        (["run", "nobody"], "nobody: no such entrant; give FILE:Class or module:Class, or one of locked"),
        (["run", "no_file.py:Me"], "no_file.py: no such file"),
        (["run", "math:Nothing"], "math:Nothing: math has no class Nothing"),
        (["run", "no.such.module:Me"], "no.such.module: cannot be loaded: ModuleNotFoundError"),
        (["run", "locked", "--cases", "b99"], "--cases b99: no such case; known: b2_calm_300"),
        (["run", "locked", "--seeds", "0"], "--seeds 0: must be at least 1"),
        (["run", "locked", "--processes", "0"], "--processes 0: must be at least 1"),
        (["run", "locked", "--duration", "nan"], "--duration nan: must be a number above 0"),
        (
            ["run", "locked", "--cases", "u2_hold", "--duration", "60"],
            "--duration: 60 s leaves nothing of case u2_hold",
        ),
        (["run", "locked", "--cases", "z_rough"], "case z_rough needs the record of the rough sea"),
        (["list", "--records", "/no/folder"], "--records /no/folder: no such folder"),
    ],
)
def test_mistakes_are_told_in_one_line(arguments: list[str], words: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("HEAVE_BENCHMARK_RECORDS", raising=False)
    with pytest.raises(ParameterError) as told:
        heave_benchmark(*arguments)
    assert str(told.value).startswith(words)
    assert "\n" not in str(told.value)


def test_records_are_found_in_a_checkout_and_as_csv_and_are_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    time = np.arange(0.0, 2000.0, 0.1)
    heave = np.sin(0.6 * time)
    (tmp_path / "deep" / "down").mkdir(parents=True)
    savemat(tmp_path / "deep" / "down" / "rough.mat", {"response1": np.column_stack((time, heave))})
    table = np.column_stack((time, heave))[:12001]
    np.savetxt(tmp_path / "zinage_moderate.csv", table, delimiter=",", header="time_s,z_m", fmt="%.6f")
    assert find_record(tmp_path, "slight") is None
    matlab, text = (read_record(find_record(tmp_path, name) or Path()) for name in ("rough", "moderate"))
    assert matlab.time[-1] == text.time[-1] == pytest.approx(1200.0)
    assert matlab.digest == text.digest
    monkeypatch.setenv("HEAVE_BENCHMARK_RECORDS", str(tmp_path))
    assert records_folder(None) == tmp_path
    bad = tmp_path / "zinage_slight.csv"
    bad.write_text("time,heave\n0.0,a\n")
    with pytest.raises(ParameterError, match=r"zinage_slight.csv: is not a record of time and heave"):
        read_record(bad)


def test_shipped_entrants_load() -> None:
    assert all(callable(Named(name).load()) for name in SHIPPED)
