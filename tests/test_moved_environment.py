"""An environment that was moved leads to its old place: make says so and makes it again, and `heave` itself says so."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


def make_help(folder, first_lines):
    """Run `make help` beside an environment whose `heave` has these `first_lines`; return what it printed."""
    shutil.copy(ROOT / "Makefile", folder)
    programs = folder / ".venv" / "bin"
    programs.mkdir(parents=True)
    (programs / "heave").write_text(first_lines)
    return subprocess.run(["make", "help"], cwd=folder, capture_output=True, text=True, check=True).stdout


@pytest.mark.parametrize(
    "first_lines", ["#!{}/.venv/bin/python3\nimport sys\n", '#!/bin/sh\nmade_at="{}/.venv/bin/"\n']
)
@pytest.mark.parametrize("is_moved", [True, False])
def test_an_environment_that_was_moved_is_made_again_and_another_is_not(tmp_path, is_moved, first_lines):
    other = tmp_path / "before"
    (other / ".venv" / "bin").mkdir(parents=True)
    here = tmp_path / "here"
    here.mkdir()
    printed = make_help(here, first_lines.format(other if is_moved else here))
    assert ("and moved: it is made again" in printed) == is_moved
    assert (here / ".venv").exists() != is_moved
    assert "make run" in printed


@pytest.mark.parametrize("is_moved", [True, False])
def test_heave_of_an_environment_that_was_moved_says_so_in_one_line(tmp_path, is_moved):
    programs = tmp_path / "made here" / ".venv" / "bin"
    programs.mkdir(parents=True)
    (programs / "python").write_text(f'#!/bin/sh\nexec {sys.executable} "$@"\n')
    (programs / "python").chmod(0o755)
    subprocess.run(["sh", ROOT / "tools" / "launcher.sh", programs.parent], check=True)
    if is_moved:
        programs = (tmp_path / "made here").rename(tmp_path / "moved") / ".venv" / "bin"
    (tmp_path / "heave").symlink_to(programs / "heave")  # as a link in ~/bin
    done = subprocess.run([tmp_path / "heave", "--version"], check=False, capture_output=True, text=True)
    assert done.returncode == int(is_moved)
    assert (done.stdout == "") == is_moved
    assert re.fullmatch("heave: this environment was made at .* and moved to .*: run make.*\n" * is_moved, done.stderr)
