"""The notebooks run from their first cell to their last, and are stored without what they print."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

import nbformat
import pytest
from domain_coordinator import domain_id

from tests.guide import ROOT, SHARE, shortened
from tests.loop_runs import environment

NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))
TIMES = "DURATION, "
"""Beginning of the line that says how long the runs of a notebook last."""
SHARE_OF_A_RUN = 0.5
"""Share of the stated times, where a notebook starts `heave run` for its verdict: the controller needs 40 s."""


def code_of(path: Path) -> list[str]:
    return [cell.source for cell in nbformat.read(path, 4).cells if cell.cell_type == "code"]


def test_there_are_notebooks():
    assert {path.stem for path in NOTEBOOKS} >= {
        "first_analysis",
        "comparing_laws",
        "better_gain",
        "designing_a_controller",
        "thesis_in_ten_figures",
    }


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_small_well_formed_and_without_outputs(path):
    book = nbformat.read(path, 4)
    nbformat.validate(book)
    assert path.stat().st_size < 20_000
    assert all(not cell.outputs and cell.execution_count is None for cell in book.cells if cell.cell_type == "code")
    for source in code_of(path):
        compile(source, path.name, "exec")
    assert book.cells[0].source.startswith("# ")


def figures(book: nbformat.NotebookNode) -> int:
    outputs = [output for cell in book.cells for output in cell.get("outputs", [])]
    return sum("image/png" in output.get("data", {}) for output in outputs)


def execute(path: Path, folder: Path, change: Callable[[str], str]) -> None:
    """Run a notebook from its first cell to its last, after a `change` of its code; all its figures must come."""
    nbclient = pytest.importorskip("nbclient", reason="nbclient is not installed")
    pytest.importorskip("ipykernel", reason="no Jupyter kernel is installed")
    book = nbformat.read(path, 4)
    for cell in book.cells:
        if cell.cell_type == "code":
            cell.source = change(cell.source)
    place = {"metadata": {"path": str(folder)}}
    with domain_id() as domain, pytest.MonkeyPatch.context() as patch:
        for name, value in environment(domain).items():
            patch.setenv(name, value)
        patch.setenv("MPLBACKEND", "module://matplotlib_inline.backend_inline")
        nbclient.NotebookClient(book, kernel_name="python3", timeout=1500, resources=place).execute()
    assert figures(book) == {"thesis_in_ten_figures": 10, "first_analysis": 2}.get(path.stem, 1)


@pytest.mark.slow
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(path, tmp_path):
    """Every cell, with shorter runs: the line of its times is the only one that differs."""
    share = SHARE_OF_A_RUN if "subprocess.run(" in "".join(code_of(path)) else SHARE
    execute(path, tmp_path, partial(shortened, share=share))


@pytest.mark.long
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("path", [path for path in NOTEBOOKS if TIMES in path.read_text()], ids=lambda path: path.stem)
def test_a_notebook_runs_to_its_end(path, tmp_path):
    execute(path, tmp_path, str)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_whose_runs_take_time_has_one_line_that_says_how_long(path):
    lines = [line for source in code_of(path) for line in source.splitlines()]
    shorter = [line for source in code_of(path) for line in shortened(source).splitlines()]
    changed = [line for line, short in zip(lines, shorter, strict=True) if line != short]
    assert len(changed) == (1 if any("ClosedLoop(" in line or "subprocess.run(" in line for line in lines) else 0)
    assert all(line.startswith(TIMES) for line in changed)
