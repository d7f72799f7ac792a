"""FMU files: FMPy validates them, and closed in FMPy and in libcosim they give the figures of a campaign's case."""

import math
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from heave_bags.analyse import kpi_set
from heave_bringup.closed_loop import LoopRecord, loop_parameters
from heave_bringup.run.loop_signals import run_signals
from heave_bringup.scenarios import load_scenario
from heave_studies.study.plan import Case
from heave_studies.study.runs import Task, run_task

pytest.importorskip("pythonfmu", reason="pythonfmu is not installed: the extra fmu")
fmpy = pytest.importorskip("fmpy", reason="fmpy is not installed: the extra fmu")

from heave_fmu.export import export_part, write_system  # noqa: E402

ORDER = ("controller", "winch", "vessel", "plant")
AGREEMENT = 1e-9
"""Largest difference of a figure, of its size and absolute: what the FMUs are asked for; they give the same bits."""


@pytest.fixture(scope="module")
def scenario():
    return load_scenario("b2_calm_300", settings=["all.duration=40", "all.transient=30"])


@pytest.fixture(scope="module")
def folder(scenario, tmp_path_factory):
    made = tmp_path_factory.mktemp("fmus")
    for part in ORDER:
        export_part(scenario, part, made)
    write_system(scenario, made)
    return made


@pytest.fixture(scope="module")
def campaign_kpis(scenario):
    result = run_task(Task(Case(1, 1, {}), scenario))
    assert not result.failure
    return result.kpis


@pytest.mark.parametrize("part", ORDER)
def test_fmpy_validates_each(folder, part):
    from fmpy.validation import validate_fmu  # noqa: PLC0415

    assert validate_fmu(str(folder / f"{part}.fmu")) == []
    description = fmpy.read_model_description(str(folder / f"{part}.fmu"))
    assert all(variable.description for variable in description.modelVariables)


@pytest.mark.slow
@pytest.mark.parametrize("master", ["fmpy", "libcosimpy"])
def test_closed_by_a_master_they_give_the_figures_of_a_campaign(scenario, folder, campaign_kpis, tmp_path, master):
    pytest.importorskip(master, reason=f"{master} is not installed: the extra fmu")
    file = tmp_path / "rows.npz"
    # a process of its own, as a user has it: PythonFMU's library must not be loaded again once it was freed
    program = [sys.executable, str(Path(__file__).parent / "fmu_loops.py"), master, str(folder), str(file)]
    times = [str(scenario.run.tick_period), str(scenario.run.duration)]
    subprocess.run([*program, *times], check=True, timeout=300)
    with np.load(file) as found:
        signals = run_signals(LoopRecord(found["rows"], found["modes"].tolist()), loop_parameters(scenario))
    figures = kpi_set.evaluate_run(signals, scenario.run.transient, scenario.run.duration)
    known = {name for name, value in campaign_kpis.items() if math.isfinite(value)}
    assert len(known) > 40
    assert campaign_kpis["unit_efficiency"] > 0.5
    assert {name for name, value in figures.items() if math.isfinite(value)} == known
    for name in known:
        assert figures[name] == pytest.approx(campaign_kpis[name], rel=AGREEMENT, abs=AGREEMENT), name


def test_an_export_of_the_same_scenario_is_the_same_but_for_another_it_is_told_apart(scenario, folder, tmp_path):
    def identity(file):
        return fmpy.read_model_description(str(file)).guid

    again = export_part(scenario, "winch", tmp_path)
    other = replace(scenario, run=replace(scenario.run, seed=7))
    assert identity(again) == identity(folder / "winch.fmu")
    assert identity(export_part(other, "winch", tmp_path)) != identity(folder / "winch.fmu")
