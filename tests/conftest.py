"""What several tests look at: one run of the calm sea, recorded."""

import fcntl
import os
from pathlib import Path

import pytest

from tests.loop_runs import CALM_DURATION, run_scenario


@pytest.fixture(scope="session")
def calm_bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the bag; of several workers the first that needs it makes it for all."""
    folder = tmp_path_factory.getbasetemp()
    folder = folder.parent if "PYTEST_XDIST_WORKER" in os.environ else folder
    with (folder / "calm.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        run = folder / "calm"
        return run / "bag" if run.exists() else run_scenario(run, duration=CALM_DURATION)
