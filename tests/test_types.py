"""The types of everything are right: minutes of mypy on a clean checkout, beside the other tests."""

import subprocess
import sys
from pathlib import Path

import nbformat
import pytest

ROOT = Path(__file__).parents[1]


def check_types(*arguments):
    """Fail where mypy with some arguments finds anything."""
    command = [sys.executable, "-m", "mypy", *arguments]
    ran = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stdout + ran.stderr


@pytest.mark.slow
def test_mypy_finds_nothing():
    check_types()


@pytest.mark.slow
def test_the_notebooks_call_what_there_is(tmp_path):
    # they are run in the validation alone
    for notebook in (ROOT / "docs" / "notebooks").glob("*.ipynb"):
        cells = [cell.source for cell in nbformat.read(notebook, 4).cells if cell.cell_type == "code"]
        (tmp_path / f"{notebook.stem}.py").write_text("\n\n".join(cells), encoding="utf-8")
    lenient = ["--allow-untyped-calls", "--allow-untyped-defs", "--disable-error-code=list-item"]
    check_types(*lenient, *map(str, sorted(tmp_path.glob("*.py"))))
