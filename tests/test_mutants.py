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


def test_what_helps_tests_is_loaded_anew_with_each_mutant():
    """It held the sound module, and no mutant of the guard was caught."""
    importlib.import_module("tests.supervised")
    assert "tests.supervised" in _importers("winch_controller_node.core.supervision.guard")


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
