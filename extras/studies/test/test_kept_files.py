"""Files that a study's cases read: kept in its table, made good where they are gone, missed where they differ."""

from __future__ import annotations

import hashlib
import os
import shutil
from importlib import resources
from pathlib import Path

import numpy as np
import pandas
import pytest
from heave_bringup.cli import main
from heave_bringup.scenarios import load_scenario
from heave_node.parameters import ParameterError
from heave_studies.study import case_file, cases
from heave_studies.study.case_file import (
    FILE_MARK,
    digest_of,
    files_of,
    keep_files,
    make_good,
    read_cases,
    write_case,
    write_cases,
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
    assert read_by(scenario).is_relative_to(tmp_path / "mine_files")
    assert read_by(scenario).read_bytes() == RAO.read_bytes()
    assert f"{rao} is not there" in line
    again, row = run_task(Task(next(own_study.cases()), scenario)).kpis, frame.set_index("case").loc[2]
    assert {key: value for key, value in again.items() if np.isfinite(value)} == {
        key: row[key] for key in again if np.isfinite(row[key])
    }


def test_a_file_that_changed_is_told_and_what_was_kept_is_read(own_study, rao, tmp_path, monkeypatch):
    output = pretended_table(own_study, tmp_path, monkeypatch)
    path, remade = write_case(f"{output}:1", tmp_path / "mine.yaml")
    assert (read_by(load_scenario(str(path))), remade) == (rao, [])
    assert not (tmp_path / "mine_files").exists(), "a file that is there is read where it is"
    rao.write_text(rao.read_text() + "\n")
    path, (line,) = write_case(f"{output}:1", tmp_path / "mine.yaml")
    assert f"{rao} has changed since the case was run" in line
    assert hashlib.sha256(RAO.read_bytes()).hexdigest()[:12] in line
    assert digest_of(read_by(load_scenario(str(path)))) == digest_of(RAO)
    # the folder can be moved: the scenario names the file beside it
    moved = tmp_path / "elsewhere"
    moved.mkdir()
    for name in ("mine.yaml", "mine_files"):
        (tmp_path / name).rename(moved / name)
    assert read_by(load_scenario(str(moved / "mine.yaml"))).is_relative_to(moved)


def test_a_file_is_in_the_table_once_and_no_fact_of_it(own_study, rao, tmp_path, monkeypatch):
    output = pretended_table(own_study, tmp_path, monkeypatch)
    import pyarrow.parquet  # noqa: PLC0415

    names = [name for name in pyarrow.parquet.read_schema(output).metadata if name.startswith(FILE_MARK)]
    assert names == [FILE_MARK + digest_of(rao).encode()]
    frame, about = read_cases(output)
    assert not [name for name in about if "file" in name]
    assert files_of(output, 2)[0] == {str(rao): digest_of(rao)}
    assert len(frame) == 2


def test_a_file_too_large_to_be_kept_is_known_by_its_digest(own_study, rao, tmp_path, monkeypatch):
    monkeypatch.setattr(case_file, "MOST_KEPT", 1000)
    output = pretended_table(own_study, tmp_path, monkeypatch)
    assert write_case(f"{output}:1", tmp_path / "mine.yaml")[1] == []
    rao.unlink()
    with pytest.raises(
        ParameterError, match=r"own_rao\.csv is not there .* was too large for the table to keep"
    ) as told:
        write_case(f"{output}:1", tmp_path / "other.yaml")
    assert "\n" not in str(told.value)
    assert not (tmp_path / "other.yaml").exists()


def test_a_study_whose_file_changed_in_between_is_another_one(own_study, rao, tmp_path, monkeypatch):
    output = pretended_table(own_study, tmp_path, monkeypatch)
    run_study(Cases(own_study), output.parent, processes=1)[0]
    rao.write_text(rao.read_text() + "\n")
    with pytest.raises(ParameterError, match="holds results of another study"):
        run_study(Cases(own_study), output.parent, processes=1)[0]


def test_a_bag_is_kept_with_all_its_files_and_equal_ones_give_equal_bytes(tmp_path):
    bag = tmp_path / "bag"
    (bag / "deeper").mkdir(parents=True)
    (bag / "metadata.yaml").write_text("version: 9\n")
    (bag / "deeper" / "bag_0.mcap").write_bytes(os.urandom(5000))
    (file,) = keep_files([str(bag)]).values()
    assert (file.name, file.size) == ("bag", 5011)
    os.utime(bag / "metadata.yaml", (1e9, 1e9))
    assert keep_files([str(bag)]) == {str(bag): file}
    before = digest_of(bag)
    shutil.rmtree(bag)
    anew, _ = make_good({str(bag): before}, {before: file}, [str(bag)], tmp_path / "run", "own.parquet:1")
    assert digest_of(Path(anew[str(bag)])) == before


def test_as_much_as_is_kept_can_be_read_by_anyone(tmp_path):
    large, small = tmp_path / "large.bin", tmp_path / "small.bin"
    large.write_bytes(os.urandom(case_file.MOST_KEPT - 20_000))  # which no packing shrinks
    small.write_bytes(b"1")
    files = keep_files([str(large), str(small)])
    assert all(file.packed for file in files.values())
    frame = pandas.DataFrame({"case": [1], "scenario": ["text"], "files": [""]})
    write_cases(frame, tmp_path / "own.parquet", {}, files.values())
    pandas.testing.assert_frame_equal(pandas.read_parquet(tmp_path / "own.parquet"), frame)
    assert set(files_of(tmp_path / "own.parquet", 1)[1].values()) == set(files.values())


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
