"""A case of a table as a scenario; a study whose input files changed is another one."""

from __future__ import annotations

import shutil
from importlib import resources
from pathlib import Path

import pytest
from heave_bringup.cli import main
from heave_bringup.scenarios import load_scenario
from heave_node.parameters import ParameterError
from heave_studies.study import cases
from heave_studies.study.cases import Cases
from heave_studies.study.engine import run_study
from heave_studies.study.runs import CaseResult, Task
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


def test_a_study_whose_file_changed_in_between_is_another_one(own_study, rao, tmp_path, monkeypatch):
    output = pretended_table(own_study, tmp_path, monkeypatch)
    run_study(Cases(own_study), output.parent, processes=1)[0]
    rao.write_text(rao.read_text() + "\n")
    with pytest.raises(ParameterError, match="holds results of another study"):
        run_study(Cases(own_study), output.parent, processes=1)[0]


def test_the_command_writes_a_case_and_prints_the_line_that_runs_it(own_study, tmp_path, monkeypatch, capsys):
    output = pretended_table(own_study, tmp_path, monkeypatch)
    monkeypatch.chdir(tmp_path)
    assert main(["study", "--case", f"{output}:1"]) == 0
    assert capsys.readouterr().out.endswith("next: heave run table_case_1.yaml\n")
    assert load_scenario("table_case_1.yaml").run.duration == 3.0
    assert main(["run", f"{output}:1"]) == 2
    assert f"`heave study --case {output}:1` writes its scenario" in capsys.readouterr().err
