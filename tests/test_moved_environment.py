"""An environment that was moved leads to its old place: make says so and makes it again, and leaves another alone."""

import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


def make_help(folder, made_at):
    """Run `make help` beside an environment whose programs name the Python of `made_at`; return what it printed."""
    shutil.copy(ROOT / "Makefile", folder)
    programs = folder / ".venv" / "bin"
    programs.mkdir(parents=True)
    (programs / "heave").write_text(f"#!{made_at}/.venv/bin/python3\nimport sys\n")
    return subprocess.run(["make", "help"], cwd=folder, capture_output=True, text=True, check=True).stdout


@pytest.mark.parametrize("is_moved", [True, False])
def test_an_environment_that_was_moved_is_made_again_and_another_is_not(tmp_path, is_moved):
    other = tmp_path / "before"
    (other / ".venv" / "bin").mkdir(parents=True)
    here = tmp_path / "here"
    here.mkdir()
    printed = make_help(here, other if is_moved else here)
    assert ("and moved: it is made again" in printed) == is_moved
    assert (here / ".venv").exists() != is_moved
    assert "make run" in printed
