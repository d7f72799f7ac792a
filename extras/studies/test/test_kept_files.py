"""Files that a study's cases read: copied beside its table, read there where they are gone or differ."""

from __future__ import annotations

import hashlib
import os
import shutil
from importlib import resources
from pathlib import Path

import numpy as np
import pytest
from heave_bringup.cli import main
from heave_bringup.scenarios import load_scenario
from heave_node.parameters import ParameterError
from heave_studies.study import case_file, cases
from heave_studies.study.case_file import (
    digest_of,
    keep_files,
    read_files,
    write_case,
)
from heave_studies.study.cases import Cases
from heave_studies.study.engine import run_study
from heave_studies.study.runs import CaseResult, Task, run_task
from heave_studies.study.study_file import read_study

RAO = Path(str(resources.files("wave_vessel_node"))) / "data" / "wigley_90m.csv"
PLACE = "vessel.rao_file"


@pytest.fixture
def rao(tmp_path: Path) -> Path:
    """Return the RAO table of the user, which the study reads."""
    return Path(shutil.copy(RAO, tmp_path / "own_rao.csv"))


@pytest.fixture
def own_study(tmp_path: Path, rao: Path):
    path = tmp_path / "own.yaml"
    path.write_text(f"""
scenario: unit_1500
duration: 3
seeds: 2
set: {{all.transient: 1.0, wave_vessel.ramp: 0.5, cable_sim.segments: 2, wave_vessel.{PLACE}: {rao}}}
""")
    return read_study(path)


def pretended(task: Task) -> CaseResult:
    return CaseResult(task.case)


def pretended_table(own_study, folder: Path, monkeypatch) -> Path:
    """Return the file of a study whose cases were not really run."""
    monkeypatch.setattr(cases, "run_task", pretended)
    run_study(Cases(own_study), folder, processes=1)
    return folder / "table.parquet"


def read_by(scenario) -> Path:
    return Path(scenario.parameters["wave_vessel"].vessel.rao_file)


def test_a_row_repeats_its_case_when_the_file_that_it_read_is_gone(own_study, rao, tmp_path):
    output = tmp_path / "table.parquet"
    frame = run_study(Cases(own_study), output.parent, processes=1)[0]
    rao.unlink()
    path, (line,) = write_case(f"{output}:2", tmp_path / "mine.yaml")
    scenario = load_scenario(str(path))
    assert read_by(scenario).is_relative_to(tmp_path / "files")
    assert read_by(scenario).read_bytes() == RAO.read_bytes()
    assert f"{rao} is not there" in line
    again, row = run_task(Task(next(own_study.cases()), scenario)).kpis, frame.set_index("case").loc[2]
    assert {key: value for key, value in again.items() if np.isfinite(value)} == {
        key: row[key] for key in again if np.isfinite(row[key])
    }


def test_a_file_that_changed_is_told_and_its_copy_is_read(own_study, rao, tmp_path, monkeypatch):
    output = pretended_table(own_study, tmp_path, monkeypatch)
    path, reported = write_case(f"{output}:1", tmp_path / "mine.yaml")
    assert (read_by(load_scenario(str(path))), reported) == (rao, []), "a file that is there is read where it is"
    rao.write_text(rao.read_text() + "\n")
    path, (line,) = write_case(f"{output}:1", tmp_path / "mine.yaml")
    assert f"{rao} has changed since the case was run" in line
    assert hashlib.sha256(RAO.read_bytes()).hexdigest()[:12] in line
    assert digest_of(read_by(load_scenario(str(path)))) == digest_of(RAO)
    # the folder can be moved: the scenario names the file beside it
    moved = tmp_path / "elsewhere"
    moved.mkdir()
    for name in ("mine.yaml", "files"):
        (tmp_path / name).rename(moved / name)
    assert read_by(load_scenario(str(moved / "mine.yaml"))).is_relative_to(moved)


def test_a_file_without_its_copy_is_named_and_no_scenario_is_written(own_study, rao, tmp_path, monkeypatch):
    monkeypatch.setattr(case_file, "MOST_KEPT", 1000)
    output = pretended_table(own_study, tmp_path, monkeypatch)
    assert write_case(f"{output}:1", tmp_path / "mine.yaml")[1] == []
    rao.unlink()
    with pytest.raises(ParameterError, match=r"own_rao\.csv is not there .* there is no copy of it") as told:
        write_case(f"{output}:1", tmp_path / "other.yaml")
    assert "\n" not in str(told.value)
    assert not (tmp_path / "other.yaml").exists()


def test_a_study_whose_file_changed_in_between_is_another_one(own_study, rao, tmp_path, monkeypatch):
    output = pretended_table(own_study, tmp_path, monkeypatch)
    run_study(Cases(own_study), output.parent, processes=1)[0]
    rao.write_text(rao.read_text() + "\n")
    with pytest.raises(ParameterError, match="holds results of another study"):
        run_study(Cases(own_study), output.parent, processes=1)[0]


def test_a_bag_is_kept_with_all_its_files(tmp_path):
    bag = tmp_path / "bag"
    (bag / "deeper").mkdir(parents=True)
    (bag / "metadata.yaml").write_text("version: 9\n")
    (bag / "deeper" / "bag_0.mcap").write_bytes(os.urandom(5000))
    (file,) = read_files([str(bag)]).values()
    assert (file.size, file.state()) == (5011, "")
    keep_files([file], tmp_path)
    assert digest_of(file.kept_in(tmp_path)) == file.digest
    (bag / "metadata.yaml").write_text("version: 8\n")
    assert "has changed" in file.state()


def test_the_command_writes_a_case_and_prints_the_line_that_runs_it(own_study, rao, tmp_path, monkeypatch, capsys):
    output = pretended_table(own_study, tmp_path, monkeypatch)
    rao.unlink()
    monkeypatch.chdir(tmp_path)
    assert main(["study", "--case", f"{output}:1"]) == 0
    told = capsys.readouterr()
    assert told.out.endswith("next: heave run table_case_1.yaml\n")
    assert told.err.count("is not there") == 1
    assert load_scenario("table_case_1.yaml").run.duration == 3.0
    assert main(["run", f"{output}:1"]) == 2
    assert f"`heave study --case {output}:1` writes its scenario" in capsys.readouterr().err
