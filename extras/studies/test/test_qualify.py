"""The evidence for a release: every claim has a test, errors are those that tests found, and no failure is hidden."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pandas
import pytest
import yaml
from heave_bringup.cli import main
from heave_bringup.errors import CommandError, ExitStatus
from heave_bringup.pages.hazards import all_cases
from heave_studies.qualify import claims, determinism, page, results, sensitivity
from heave_studies.qualify.failures import chapters

ROOT = Path(__file__).parents[3]

TESTS = """
import time
import numpy as np
import pandas
import pytest

@pytest.mark.parametrize("found", [1.0, 1.02, 1.01])
def test_good(found):
    assert found == pytest.approx(1.0, rel=0.05)
    assert not found == pytest.approx(3.0, abs=0.1)
    assert found != pytest.approx(3.0, abs=0.1)
    for value in (2.0, 2.25):
        assert [value, 2.0] == pytest.approx([2.0, 2.0], abs=0.5)
    np.testing.assert_allclose(np.array([3.0, 3.3]), 3.0, rtol=0.2)

def test_bad():
    assert 5.0 == pytest.approx(4.0, abs=0.5)

@pytest.mark.slow
@pytest.mark.parametrize("seconds", [0.0, 60.0])
def test_slow(seconds):
    time.sleep(seconds)

def test_skipped():
    pytest.skip("no peer")
"""
"""Errors by hand: 0.02 of 0.05; 0.25 of 0.5; 0.3 of 0.6; 1 of 0.5."""
NAMES = ("good", "bad", "slow", "skipped")


@pytest.fixture
def tree(tmp_path, monkeypatch):
    """Return a source tree of one file of tests, with a model whose claims name them."""
    root = tmp_path / "tree"
    (root / "tests" / "validation").mkdir(parents=True)
    (root / "pyproject.toml").write_text("[tool.pytest.ini_options]\nmarkers = ['slow: slow', 'long: long']\n")
    (root / "tests" / "test_it.py").write_text(TESTS)
    (root / "tests" / "comparisons.py").write_text((ROOT / "tests" / "comparisons.py").read_text())
    own = yaml.safe_load(claims.FILE.read_text())[0]
    own["claims"] = [
        {"claim": name, "reference": "hand", "tests": [f"tests/test_it.py::test_{name}"]} for name in NAMES
    ]
    (tmp_path / "models.yaml").write_text(yaml.safe_dump([own]))
    for module in (claims, results):
        monkeypatch.setattr(module, "TREE", root)
    monkeypatch.setattr(claims, "FILE", tmp_path / "models.yaml")
    return root


def test_every_claim_names_tests_that_exist_a_reference_and_its_model_a_domain_and_limits():
    models = claims.read_models()
    assert len({model.key for model in models}) == len(models) > 10
    for model in models:
        assert set(model.domain) == set(claims.DOMAIN), model.name
        assert all(isinstance(bounds, str) or bounds[0] <= bounds[1] for bounds in model.domain.values())
        assert model.limits
        assert all((ROOT / folder).is_dir() for folder in model.code.split(", "))
        assert all(one.reference and one.tests for one in model.claims)


def test_a_test_that_is_none_and_a_wheel_without_tests_are_refused_in_one_line(tree, capsys):
    (tree / "tests" / "test_it.py").write_text("")
    with pytest.raises(CommandError, match=r"tests/test_it.py::test_good: there is no such test"):
        claims.read_models()
    (tree / "tests" / "validation").rmdir()
    assert main(["qualify"]) == ExitStatus.FAILED
    assert capsys.readouterr().err == (
        "heave: heave qualify runs the tests of the suite: it needs the source tree, which a wheel lacks\n"
    )


def test_errors_and_tolerances_are_those_that_the_tests_found(tree, tmp_path):
    tests = [f"tests/test_it.py::test_{name}" for name in NAMES]
    results.run_tests(tests, tmp_path, quick=True, processes=1)
    cases = results.read_cases(tmp_path)
    good, bad, slow, skipped = (results.verdict_of([test], cases) for test in tests)
    assert [one.outcome for one in (good, bad, slow, skipped)] == ["passed", "FAILED", "not run", "skipped"]
    assert skipped.message == "no peer"
    worst = {}
    for one in good.comparisons:
        worst[one["of"]] = max(worst.get(one["of"], 0.0), one["error"])
    assert worst == pytest.approx({"found": 0.02, "[value, 2.0]": 0.25, "np.array([3.0, 3.3])": 0.3})
    assert good.worst["used"] == pytest.approx(0.5)
    largest = max(good.comparisons, key=lambda one: one["relative"] and one["error"])
    assert page.numbers(largest) == ("10 %", "20 %", "3")
    assert (bad.worst["error"], bad.worst["tolerance"]) == (1.0, 0.5)
    assert results.verdict_of([tests[0], tests[2]], cases).outcome == "not run"
    assert results.verdict_of(tests, cases).outcome == "FAILED"


def test_a_claim_whose_test_fails_stands_as_failed_and_ends_with_the_status_of_a_failed_verdict(
    tree, tmp_path, monkeypatch, capsys
):
    monkeypatch.setattr(determinism, "hash_of", None)
    monkeypatch.setattr(determinism, "run_hashes", lambda folder, processes: [])
    out, answer = tmp_path / "out", tmp_path / "answer.json"
    words = ["qualify", "--quick", "--processes", "1", "--output", str(out), "--json", str(answer)]
    assert main(words) == ExitStatus.VERDICT_FAILED
    assert "verdict FAILED: Cable in three dimensions: bad" in capsys.readouterr().err
    found = json.loads(answer.read_text())
    assert [one["outcome"] for one in found["claims"]] == ["passed", "FAILED", "not run", "skipped"]
    text = (out / "evidence.html").read_text()
    assert '<tr class="level-2"><td>bad</td>' in text
    assert "5.0 == 4.0 ± 0.5" in text
    assert "4 claims: 1 passed, 1 not run" in text
    assert "No conformity is claimed" in text
    assert "http" not in text.split("<body>")[1].split("<script>")[0]  # it fetches nothing
    assert "1 of 0.5, reference 4<br>" in text
    assert (out / "cases" / "calm" / "calm.cases").is_file()
    assert (out / "versions.txt").read_text().count("\n") > 20


@pytest.mark.parametrize("processes", [1, 2])
def test_ctrl_c_keeps_the_results_of_the_tests_that_are_done(tree, tmp_path, processes):
    """The whole group gets the signal, as from a terminal; SIGINT is ignored at first, as in the background."""
    program = (
        "import signal, sys; from pathlib import Path; from heave_studies.qualify import results\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        f"results.TREE = Path({str(tree)!r})\n"
        f"results.run_tests(sys.argv[1:], Path({str(tmp_path)!r}), quick=False, processes={processes})\n"
    )
    tests = [f"tests/test_it.py::test_{name}" for name in ("good", "slow")]
    words = ["sh", "-c", 'trap "" INT; exec "$@"', "sh", sys.executable, "-c", program, *tests]
    child = subprocess.Popen(words, stderr=subprocess.DEVNULL, start_new_session=True)
    try:
        log, end = tmp_path / results.LOG, time.monotonic() + 60.0
        while not (log.exists() and log.read_text().count("PASSED") == 4) and time.monotonic() < end:
            time.sleep(0.2)
        os.killpg(child.pid, signal.SIGINT)
        child.wait(60.0)
    finally:
        child.kill()
    cases = results.read_cases(tmp_path)
    assert results.verdict_of(tests[:1], cases).outcome == "passed"
    assert len(cases) == 4
    assert results.verdict_of(tests[1:], cases).outcome == "not run"  # one of its two cases is


def test_runs_that_differ_are_a_failure_and_other_machines_stand_beside(tmp_path, monkeypatch):
    hashes = iter(["a", "a", "b", "b", "a", "a", "c", "c"])

    def process(*_, **__):
        found = {name: [next(hashes) for _ in range(determinism.REPEATS)] for name in determinism.SCENARIOS}
        return subprocess.CompletedProcess([], 0, json.dumps(found), "")

    monkeypatch.setattr(determinism.subprocess, "run", process)
    (tmp_path / "determinism_other.json").write_text(json.dumps({"machine": "another", "hashes": {}}))
    own, other = determinism.run_hashes(tmp_path, 2)
    assert other["machine"] == "another"
    assert own["hashes"] == dict(zip(determinism.SCENARIOS, (["a"] * 4, ["b", "b", "c", "c"]), strict=True))
    assert determinism.differences([own, other]) == [f"determinism: runs of {determinism.SCENARIOS[1]} differ"]
    assert determinism.differences([]) == []


def test_every_case_of_the_matrix_of_faults_is_in_a_chapter():
    rows = [row for one in chapters() for row in one["rows"]]
    pairs = {(case["fault"], case["moment"]) for case in all_cases()}
    assert {(row[0], row[1]) for row in rows} == pairs
    counts = {(row[0], row[1]): int(row[2]) for row in rows}
    assert sum(counts.values()) == len(all_cases())


def test_a_scenario_outside_the_domain_of_a_model_says_so():
    cable = next(model for model in claims.read_models() if model.key == "cable")
    inside = {"hs": 1.0, "tp": 6.0, "depth": 300.0, "ea": 1.5e7, "tick": 0.05}
    assert cable.misses(inside) == []
    assert cable.misses({**inside, "ea": 4.2e8, "depth": 5000.0}) == ["depth", "ea"]


def test_limits_are_read_from_the_documents():
    given = yaml.safe_load(claims.FILE.with_name("evidence.yaml").read_text())
    for one in given["limits_from"]:
        assert len(page.section(ROOT / one["file"], one["heading"])) >= 3, one


def test_the_chapter_of_sensitivity_ranks_the_parameters_of_the_study(tmp_path, monkeypatch):
    """A load that follows the wave height, not the noise: Spearman by hand 1 and 1 - 6 x 224/(12 x 143) = 0.22."""
    heights = [1.5 + 0.1 * number for number in range(12)]
    noise = [0.01 * (1 + number * 5 % 12) for number in range(12)]
    frame = pandas.DataFrame(
        {"case": range(12), "seed": 1, "nominal": False, "failure": "", "lost": False, "met": True}
    )
    frame = frame.assign(**{"wave_vessel.significant_wave_height": heights, "wave_vessel.mru.noise": noise})
    frame = frame.assign(
        unit_sigma_m=[0.01 * height for height in heights],
        uncompensated_sigma_m=0.5,
        snaps=0.0,
        uncompensated_snaps=0.0,
        scenario="",
    )
    monkeypatch.setattr(sensitivity, "run_study", lambda kind, folder, processes: (frame, {}))
    text = sensitivity.what_matters(tmp_path, 1)
    rows = text.split("<tr>")
    ranked = [row for row in rows if "<td>wave_vessel." in row]
    assert "significant_wave_height" in ranked[0]
    assert "+1.00" in ranked[0]
    assert "+0.22" in ranked[1]
    assert "none shown" in ranked[1]
    assert f"{len(frame)} cases" in text
