"""The page of the evidence: one HTML file that opens offline and prints on A4."""

from __future__ import annotations

import hashlib
import platform
import time
from collections.abc import Mapping, Sequence
from importlib import metadata
from pathlib import Path
from typing import Any

from heave_bags.record.provenance import git_commit, versions
from heave_bags.report.report import render_page
from heave_bringup.pages.hazards import newest_matrices
from heave_bringup.parser import own_version
from heave_bringup.scenarios import load_scenario, shipped_scenarios
from heave_node.files.bounded_yaml import parse_yaml
from jinja2 import Environment, StrictUndefined

from heave_studies.qualify.claims import DOMAIN, TREE, Model
from heave_studies.qualify.determinism import DURATION, REPEATS
from heave_studies.qualify.failures import chapters
from heave_studies.qualify.results import PASSED, Verdict


def render(
    models: Sequence[tuple[Model, Sequence[Verdict]]],
    cases: Sequence[Verdict],
    hashes: Sequence[Mapping[str, Any]],
    sensitivity: str,
    notes: Sequence[str],
    failures: Sequence[str],
) -> str:
    """Return the page as HTML.

    Parameters
    ----------
    models : each with the verdict of each of its claims
    cases : of all tests that were run
    hashes : as `determinism.run_hashes` gives them; empty where it was not run
    sensitivity : body of that chapter, as HTML
    notes, failures : what was not run, and what failed, in lines
    """
    here = Path(__file__)
    given = parse_yaml(here.with_name("evidence.yaml").read_text(encoding="utf-8"))
    pages = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True)
    title = f"Evidence for heave {own_version()}"
    body = pages.from_string(here.with_name("page.html").read_text(encoding="utf-8")).render(
        **{name: given[name] for name in ("use", "not_for", "read", "standards")},
        title=title,
        commit=git_commit(TREE) or "unknown",
        date=time.strftime("%Y-%m-%d %H:%M UTC", time.gmtime()),
        models=[_chapter(*one) for one in models],
        limits=[{**one, "lines": section(TREE / one["file"], one["heading"])} for one in given["limits_from"]],
        scenarios=_scenarios([model for model, _ in models]),
        duration=f"{DURATION:g}",
        repeats=REPEATS,
        hashes=hashes,
        sensitivity=sensitivity,
        matrices=newest_matrices(),
        hazards=chapters(),
        versions=[*versions().items(), *_digests()],
        comparisons=[_comparison(case.test, one) for case in cases for one in case.comparisons],
        notes=list(notes),
        failures=list(failures),
    )
    return render_page(title, body, (), footer="Made by heave qualify.")


def _chapter(model: Model, verdicts: Sequence[Verdict]) -> dict[str, Any]:
    rows = [
        {**vars(claim), **vars(verdict), "worst": verdict.worst, "numbers": numbers(verdict.worst)}
        for claim, verdict in zip(model.claims, verdicts, strict=True)
    ]
    used = [float(one.worst["used"]) for one in verdicts if one.worst]
    ranges = {
        name: " to ".join(dict.fromkeys(f"{value:g}".replace("e+0", "e") for value in bounds))
        if isinstance(bounds, list)
        else bounds
        for name, bounds in model.domain.items()
    }
    return {
        **vars(model),
        "domain": [[name, DOMAIN[name], words] for name, words in ranges.items()],
        "claims": rows,
        "passed": sum(one.outcome == PASSED for one in verdicts),
        "used": f"{100.0 * max(used):.2g} %" if used else "-",
    }


def numbers(one: Mapping[str, Any] | None) -> tuple[str, ...]:
    """Return error, tolerance and reference of `one` comparison: SI, the first two in % where the test does so."""
    if one is None:
        return "-", "-", "-"
    is_share = one["relative"] and one["reference"] > 0.0
    values = [one[name] / (one["reference"] if is_share else 1.0) for name in ("error", "tolerance")]
    words = (f"{100.0 * value:.2g} %" if is_share else f"{value:.2g}" for value in values)
    return *words, f"{one['reference']:.3g}"


def _comparison(test: str, one: Mapping[str, Any]) -> list[str]:
    return [test.rpartition("/")[2], one["of"], str(one["count"]), *numbers(one), f"{100.0 * one['used']:.2g} %"]


def section(path: Path, heading: str) -> list[str]:
    """Return the lines of the list under a `heading` of the Markdown file at a `path`, without marks of code."""
    text = path.read_text(encoding="utf-8").partition(f"## {heading}\n")[2].partition("\n## ")[0]
    return [line[2:].replace("`", "") for line in text.splitlines() if line.startswith("- ")]


def _scenarios(models: Sequence[Model]) -> list[list[str]]:
    """Return a row for each shipped scenario: name, quantities of DOMAIN, where they are outside, digest."""
    rows = []
    for name, path in shipped_scenarios().items():
        scenario = load_scenario(name, needs_files=False)
        plant, sea = scenario.parameters["cable_sim"], scenario.parameters["wave_vessel"]
        found = (sea.significant_wave_height, sea.peak_period, plant.length, plant.cable.axial_stiffness)
        values = dict(zip(DOMAIN, (*found, scenario.run.tick_period), strict=True))
        missed = [f"{model.name}: {', '.join(misses)}" for model in models if (misses := model.misses(values))]
        digest = hashlib.sha256(path.read_bytes()).hexdigest()[:16]
        rows.append([name, *(f"{value:.4g}" for value in values.values()), "; ".join(missed), digest])
    return rows


def package_list() -> str:
    """Return the installed packages with their versions, one per line, sorted."""
    return "\n".join(sorted({f"{one.name} {one.version}" for one in metadata.distributions()})) + "\n"


def _digests() -> list[tuple[str, str]]:
    machine = f"{platform.system()} {platform.release()} {platform.machine()}"
    pins = [(path.name, path.read_bytes()) for path in sorted((TREE / "constraints").glob("*"))]
    named = [("installed packages (versions.txt)", package_list().encode()), *pins]
    return [("machine", machine), *((f"SHA-256, {name}", hashlib.sha256(data).hexdigest()) for name, data in named)]
