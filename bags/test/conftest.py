"""Fixtures: bags of a made-up run."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from heave_bags.mcap.bag_writer import BagPolicy
from made_up_run import MadeUpRun, write_run


@pytest.fixture
def made_up_bag(tmp_path: Path) -> Callable[..., Path]:
    """Return a function that writes a made-up run and returns its folder."""

    def make(name: str = "run", run: MadeUpRun | None = None, policy: BagPolicy | None = None) -> Path:
        write_run(tmp_path / name, run, policy)
        return tmp_path / name

    return make


@pytest.fixture(scope="session")
def shared_bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of one made-up run of a minute, for tests that only read."""
    folder = tmp_path_factory.mktemp("bags") / "made_up"
    write_run(folder)
    return folder
