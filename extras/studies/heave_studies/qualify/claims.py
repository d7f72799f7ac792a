"""What is claimed of each model: its domain of validity, its limits, and the tests that show each claim."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from heave_bringup.errors import CommandError
from heave_node.files.bounded_yaml import parse_yaml

FILE = Path(__file__).with_name("models.yaml")
TREE = Path(__file__).resolve().parents[4]
"""Root of the source tree, where this file lies in one."""
DOMAIN = {
    "hs": "significant wave height, m",
    "tp": "peak period or period of motion, s",
    "depth": "cable out, m",
    "ea": "axial stiffness EA, N",
    "tick": "tick and step, s",
}
"""Quantities of a domain of validity: each a range of two numbers, or words."""


@dataclass(frozen=True)
class Claim:
    """A claim, and the tests that show it."""

    claim: str  # what is compared
    reference: str  # document and equation, exact solution or peer code
    tests: tuple[str, ...]  # each `file::function`


@dataclass(frozen=True)
class Model:
    """A model, and what is claimed of it."""

    name: str  # for people
    key: str  # of its chapter
    code: str  # folder that has it
    what: str  # equations and their source, in a sentence
    domain: Mapping[str, Any]  # see DOMAIN
    limits: tuple[str, ...]  # what it leaves out and why
    claims: tuple[Claim, ...]  # main ones first

    def misses(self, values: Mapping[str, float]) -> list[str]:
        """Return the quantities of DOMAIN whose `values` lie outside the domain."""
        ranges = {name: bounds for name, bounds in self.domain.items() if isinstance(bounds, list)}
        return [name for name, (low, high) in ranges.items() if not low <= values[name] <= high]


def read_models() -> tuple[Model, ...]:
    """Return the models. Raises CommandError without the source tree, and where a claim names a test that is none."""
    if not (TREE / "tests" / "validation").is_dir():
        raise CommandError("heave qualify runs the tests of the suite: it needs the source tree, which a wheel lacks")
    models = []
    for row in parse_yaml(FILE.read_text(encoding="utf-8")):
        claims = tuple(Claim(one["claim"], one["reference"], tuple(one["tests"])) for one in row["claims"])
        models.append(Model(**{**row, "limits": tuple(row["limits"]), "claims": claims}))
        for file, _, name in (test.partition("::") for claim in claims for test in claim.tests):
            if not (TREE / file).is_file() or f"def {name}(" not in (TREE / file).read_text(encoding="utf-8"):
                raise CommandError(f"{FILE.name}: {file}::{name}: there is no such test")
    return tuple(models)
