"""What several tests look at: one run of the calm sea, recorded."""

from pathlib import Path

import pytest

from tests.loop_runs import CALM_DURATION, run_scenario


@pytest.fixture(scope="session")
def calm_bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return run_scenario(tmp_path_factory.mktemp("calm") / "run", duration=CALM_DURATION)
