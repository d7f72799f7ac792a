"""Small matrices on one thread: threads of the linear algebra that wait for one another cost ten times the work."""

import os
import subprocess
import sys

import pytest

PROGRAM = """
import {module}
import numpy, os, scipy.linalg
matrix = numpy.ones((300, 300)) / 300.0
scipy.linalg.expm(matrix @ matrix)
print(len(os.listdir("/proc/self/task")))
"""


def threads(module: str, **settings: str) -> int:
    inherited = {name: value for name, value in os.environ.items() if not name.endswith("_NUM_THREADS")}
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM.format(module=module)],
        env=inherited | settings,
        capture_output=True,
        text=True,
        check=True,
    )
    return int(done.stdout)


@pytest.mark.parametrize("module", ["heave_node", "heave_bringup.closed_loop", "heave_bags"])
def test_linear_algebra_takes_one_thread_where_nothing_else_is_set(module):
    assert threads(module) == 1


@pytest.mark.skipif(len(os.sched_getaffinity(0)) < 2, reason="on one core the library never starts a second thread")
def test_a_number_of_threads_that_a_user_has_set_stays():
    assert threads("heave_node", OPENBLAS_NUM_THREADS="2") > 1
