"""The campaigns that look at the tests and at long runs, by what they must find."""

from __future__ import annotations

import ast
import importlib
import signal
import subprocess
import sys

import psutil
import pytest

from tests.campaigns.mutants.judge import ROOT, _importers
from tests.campaigns.mutants.mutations import mutated, mutations_of
from tests.campaigns.mutants.subjects import SUBJECTS
from tests.campaigns.soak import Look, Soaked, is_well, judged, memory_by_node
from tests.loop_runs import wait_until

SOURCE = '''
"""Words."""
LIMIT: float = 0.5

def act(speed: float | None, brake: bool) -> float:
    """Words."""
    if speed is None or not brake:
        return 0.0
    speed += 1.0
    note(speed)
    return min(speed, -LIMIT)
'''


def test_comparisons_conditions_arithmetic_numbers_and_statements_are_changed_one_at_a_time():
    changes = {f"{mutation.was} -> {mutation.became}" for mutation in mutations_of(SOURCE)}
    assert changes == {
        "0.5 -> 1.0",
        "0.0 -> 1.0",
        "1.0 -> 2.0",
        "speed is None or not brake -> not (speed is None or not brake)",
        "speed is None or not brake -> speed is None and (not brake)",
        "speed is None -> speed is not None",
        "not brake -> not not brake",
        "speed += 1.0 -> speed -= 1.0",
        "speed += 1.0 -> pass",
        "note(speed) -> pass",
        "return min(speed, -LIMIT) -> return None",
        "min(speed, -LIMIT) -> max(speed, -LIMIT)",
        "-LIMIT -> +LIMIT",
    }


def test_each_mutant_is_a_program_of_its_own():
    sound = ast.unparse(ast.parse(SOURCE))
    programs = {ast.unparse(mutated(SOURCE, mutation.number)) for mutation in mutations_of(SOURCE)}
    assert len(programs) == len(mutations_of(SOURCE))
    assert sound not in programs
    assert all(compile(program, "mutant", "exec") for program in programs)


@pytest.mark.parametrize("name", SUBJECTS)
def test_the_tests_of_each_module_are_there(name):
    assert all((ROOT / test).is_file() for test in SUBJECTS[name].tests)


def soaked(**growing: float) -> Soaked:
    """Return a run whose figures grow by so much to its end."""
    looks = [
        Look(
            {"plant": 300.0, "adviser": 100.0 + growing.get("memory", 0.0) * share},
            60 + round(growing.get("descriptors", 0.0) * share),
            5 + round(growing.get("files", 0.0) * share),
        )
        for share in (look / 100.0 for look in range(101))
    ]
    return Soaked("composed", 15.0, 3600.0, looks, [])


def test_what_helps_tests_is_loaded_anew_with_each_mutant():
    """It held the sound module, and no mutant of the guard was caught."""
    importlib.import_module("tests.supervised")
    assert "tests.supervised" in _importers("winch_controller_node.core.supervision.guard")


@pytest.mark.parametrize("figure", ["memory", "descriptors", "files"])
def test_a_figure_that_grows_in_a_long_run_is_found(figure):
    assert is_well(soaked())
    grown = soaked(**{figure: 30.0})
    assert [name for name, *_, has_stayed in judged(grown) if not has_stayed] == [figure]
    assert not is_well(grown)


def test_the_memory_of_each_node_is_known():
    found = memory_by_node(soaked(memory=80.0))
    assert found == {"plant": (300.0, 300.0), "adviser": (pytest.approx(129.6), pytest.approx(170.4))}


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_the_run_of_a_soak_ends_with_it(number, tmp_path):
    command = [sys.executable, "-m", "tests.campaigns.soak", "--kinds", "processes", "--folder", str(tmp_path)]
    soak = psutil.Popen(command, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        wait_until(lambda: len(soak.children(recursive=True)) > 5, 120.0)
    finally:
        started = soak.children(recursive=True)
        soak.send_signal(number)
    assert psutil.wait_procs([soak, *started], timeout=60.0)[1] == []
