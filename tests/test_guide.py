"""The documentation site is whole, needs no network, and what its pages say to type does what they say.

That each command line is one that the command takes is in `bringup/test/test_documented_examples.py`.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from tests.guide import GUIDE, READMES, ROOT, blocks

WITH_CODE = [path for path in GUIDE if any(block.is_run for block in blocks(path))]


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
    assert (site / "reference" / "commands.html").read_text().count("heave operability") > 3
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


@pytest.mark.parametrize("path", [*GUIDE, *READMES], ids=name_of)
def test_python_and_yaml_in_a_document_are_well_formed(path):
    for block in blocks(path):
        if block.language == "python":
            compile(block.text, name_of(path), "exec")
        elif block.language == "yaml":
            yaml.safe_load(block.text)


@pytest.mark.long
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("path", WITH_CODE, ids=name_of)
def test_what_a_page_says_to_type_runs(path, tmp_path):
    environment = {**os.environ, "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}", "MPLBACKEND": "agg"}
    environment["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    for block in blocks(path):
        if block.title:
            (tmp_path / block.title).write_text(block.text)
        command = {"sh": ["bash", "-euo", "pipefail", "-c"], "python": [sys.executable, "-c"]}.get(block.language)
        if command is None or not block.is_run:
            continue
        done = subprocess.run(
            [*command, block.text], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, f"{block.text}\n{done.stdout[-3000:]}\n{done.stderr[-3000:]}"
