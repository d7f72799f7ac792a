"""The first page is short, its badges are true, and each table of results names the commit that it was measured on."""

from __future__ import annotations

import re
import sys

import pytest

from tests.guide import ROOT

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

PAGES = (ROOT / "README.md", ROOT / "winch_controller_node" / "README.md")
PAGE = PAGES[0].read_text(encoding="utf-8")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


@pytest.mark.parametrize(("path", "most"), [(PAGES[0], 900), (PAGES[1], 1500)], ids=["first page", "controller"])
def test_a_page_that_is_read_first_is_short(path, most):
    assert len(path.read_text(encoding="utf-8").split()) <= most


def test_the_badges_say_what_the_package_says():
    badges = dict(re.findall(r"!\[([^\]]+)\]\(docs/pictures/(badge_\w+\.svg)\)", PAGE))
    first, last = re.findall(r"3\.(\d+)", PROJECT["requires-python"])
    python = f"3.{first} to 3.{int(last) - 1}"
    (ros,) = re.findall(r"/opt/ros/(\w+)/", (ROOT / "docs" / "guide" / "install.md").read_text(encoding="utf-8"))
    wanted = {f"Licence: {PROJECT['license']}", f"Python {python}", f"ROS 2 {ros.capitalize()}"}
    assert set(badges) == wanted
    for words, file in badges.items():
        drawn = (ROOT / "docs" / "pictures" / file).read_text(encoding="utf-8")
        assert f">{words.split(maxsplit=1)[-1].removeprefix('2 ')}<" in drawn


def test_each_table_of_results_names_its_commit():
    results = PAGE.split("## What it achieves")[1].split("\n## ")[0]
    tables = re.findall(r"(?:^\|.*\n)+\n(.*)", results, flags=re.MULTILINE)
    assert len(tables) == 2
    assert all(re.match(r"Measured at [0-9a-f]{7}\b", after) for after in tables)


def test_what_holds_a_claim_is_there():
    claims = PAGE.split("## Evidence")[1].split("\n## ")[0]
    named = [name for row in re.findall(r"\| ([^|]+) \|$", claims, flags=re.MULTILINE) for name in row.split(", ")]
    files = [name.strip("`") for name in named if name.startswith("`")]
    assert len(files) >= 7
    assert [name for name in files if not list(ROOT.glob(name if "/" in name else f"tests/**/{name}"))] == []
