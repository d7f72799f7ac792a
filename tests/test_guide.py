"""The documentation site is whole, needs no network, and what its pages say to type does what they say.

That each command line is one that the command takes is in `bringup/test/test_documented_examples.py`.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml
from domain_coordinator import domain_id
from heave_bringup.errors import ExitStatus

from tests.guide import GUIDE, PAGES, READMES, ROOT, blocks, shortened
from tests.loop_runs import environment

FIRST_PAGE = ROOT / "README.md"
WITH_CODE = [path for path in [*GUIDE, FIRST_PAGE] if any(block.is_run for block in blocks(path))]


def is_shortened(path: Path) -> bool:
    """Return whether a page states simulated times that a test may shorten."""
    return any(shortened(block.text) != block.text for block in blocks(path))


def name_of(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """Build the site as `make docs` does."""
    pytest.importorskip("material", reason="mkdocs-material is not installed: extra `docs`")
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "--quiet", "build", "--strict"]
    command += ["--config-file", str(ROOT / "docs" / "mkdocs.yml"), "--site-dir", str(folder)]
    done = subprocess.run(
        command, capture_output=True, text=True, check=False, env={**os.environ, "NO_MKDOCS_2_WARNING": "1"}
    )
    assert done.returncode == 0, done.stderr
    return folder


def test_the_site_builds_without_a_broken_link(site):
    assert (site / "index.html").is_file()
    assert (site / "reference" / "commands.html").read_text().count("heave study") > 3
    assert "MruSample" in (site / "reference" / "messages.html").read_text()


def test_a_page_fetches_nothing_from_elsewhere(site):
    fetched = re.compile(
        r'<(?:script|img|iframe|source)\b[^>]*\bsrc="?(https?:)?//|<link\b[^>]*href="?(https?:)?//[^>]*'
    )
    pages = sorted(site.rglob("*.html"))
    assert len(pages) > 40
    wrong = {page.name: found[0] for page in pages if (found := fetched.search(page.read_text(encoding="utf-8")))}
    assert wrong == {}
    assert not [path for path in site.rglob("*.css") if re.search(r"url\(\"?https?://|@import", path.read_text())]


def test_every_picture_of_the_documents_is_small():
    pictures = [path for path in (ROOT / "docs" / "pictures").rglob("*") if path.is_file()]
    assert len(pictures) > 10
    assert {path.name: path.stat().st_size for path in pictures if path.stat().st_size > 60_000} == {}


@pytest.mark.parametrize("path", [*GUIDE, *READMES, FIRST_PAGE], ids=name_of)
def test_python_and_yaml_in_a_document_are_well_formed(path):
    for block in blocks(path):
        if block.language == "python":
            compile(block.text, name_of(path), "exec")
        elif block.language == "yaml":
            yaml.safe_load(block.text)


def test_no_page_writes_over_the_scenario_that_another_page_makes():
    """A reader keeps all files in one folder: `cat > my_lift.yaml` would replace that of `heave new my_lift`."""
    typed = "\n".join(block.text for path in [*GUIDE, FIRST_PAGE] for block in blocks(path))
    made = set(re.findall(r"heave new (\w+)", typed))
    titles = {block.title.removesuffix(".yaml") for path in GUIDE for block in blocks(path)}
    assert "my_lift" in made
    assert made & ({*re.findall(r"> (\w+)\.yaml", typed)} | titles) == set()


@pytest.mark.parametrize("path", [*GUIDE, *READMES, *PAGES, *ROOT.glob("docs/*.md")], ids=name_of)
def test_every_link_of_a_document_leads_to_a_file_of_the_checkout(path):
    text = re.sub(r"^ *```.*?^ *```", "", path.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    targets = [target.partition("#")[0] for target in re.findall(r"\]\(([^()\s]+)\)", text)]
    files = [target for target in targets if target and not re.match("[a-z]+:", target)]
    assert [file for file in files if not (path.parent / file).exists()] == []


@pytest.mark.parametrize(
    ("page", "target"),
    [("which_seas", "reference/figures_of_merit"), ("use_a_bag", "notebooks/first_analysis")],
)
def test_a_link_to_what_a_page_is_written_from_is_one_to_the_page_in_the_site(site, page, target):
    text = (site / "howto" / f"{page}.html").read_text()
    assert f'href="../{target}.html' in text.partition("<article")[2]


ANY_VERDICT = f'heave() {{ command heave "$@" || [ $? -eq {ExitStatus.VERDICT_FAILED.value} ]; }}\n'
"""First line of a page's commands: a shorter run may miss what the whole one meets."""


def type_page(path: Path, folder: Path, change: Callable[[str], str]) -> None:
    """Do in an empty folder what a page says to type, after a `change` of it: each block must end without an error.

    A verdict that is FAILED is none.
    """
    with domain_id() as domain:
        variables = {**environment(domain), "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
        variables["MPLBACKEND"] = "agg"
        for block in blocks(path):
            text = change(block.text)
            if block.title:
                (folder / block.title).write_text(text)
            command = {"sh": ["bash", "-euo", "pipefail", "-c"], "python": [sys.executable, "-c"]}.get(block.language)
            if command is None or not block.is_run:
                continue
            done = subprocess.run(
                [*command, ANY_VERDICT + text if block.language == "sh" else text],
                cwd=folder,
                env=variables,
                capture_output=True,
                text=True,
                check=False,
            )
            assert done.returncode == 0, f"{text}\n{done.stdout[-3000:]}\n{done.stderr[-3000:]}"


STUDIES = (
    *("my_campaign.md", "my_cable.md", "wrong_winch.md", "less_power.md", "which_winch.md", "can_i_land_it.md"),
    *("plan_a_lift.md", "fmu.md", "lower_through_the_splash_zone.md"),
)
"""Pages of minutes, even with shorter runs: `make validate` runs them."""


@pytest.mark.slow
@pytest.mark.parametrize(
    "path",
    [pytest.param(path, marks=pytest.mark.long) if path.name in STUDIES else path for path in WITH_CODE],
    ids=name_of,
)
def test_what_a_page_says_to_type_runs(path, tmp_path):
    """Every command and line of Python of the page, with shorter runs: see `tests.guide.shortened`."""
    type_page(path, tmp_path, shortened)


@pytest.mark.long
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("path", [path for path in WITH_CODE if is_shortened(path)], ids=name_of)
def test_what_a_page_says_to_type_runs_to_its_end(path, tmp_path):
    type_page(path, tmp_path, str)


def test_a_shorter_page_differs_in_simulated_times_alone():
    text = "heave run a --duration 300 --seed 3\nheave design a --length 800\nheave study run b --duration 300\n"
    assert shortened(text) == text.replace("a --duration 300", "a --duration 18 --set all.transient=7.2")
    assert shortened("scenario: a\nduration: 240.0\n") == "scenario: a\nduration: 14.4\nset: {all.transient: 7.2}\n"
    assert shortened('["all.duration=240"]\nsigma(after=120.0)') == (
        '["all.duration=14.4", "all.transient=7.2"]\nsigma(after=7.2)'
    )
    assert shortened("DURATION, TRANSIENT = 600.0, 200.0\nrun(600.0)\n") == (
        "DURATION, TRANSIENT = 36, 12\nrun(600.0)\n"
    )
    assert sum(map(is_shortened, WITH_CODE)) > 6
