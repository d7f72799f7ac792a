"""What would have been, beside the figures of a run: computed once, kept beside the bag, and refused in words."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from heave_bags.analyse.kpis.reconstruction import Reconstruction
from heave_bags.analyse.kpis.sources import FREE_HEAVE
from heave_bags.analyse.run_record import ESTIMATED, RECONSTRUCTED, TRUE, RunRecord
from heave_bags.mcap.bag_writer import BagWriter
from heave_bags.signals import RunSignals, Signal
from heave_bringup.errors import CommandError
from heave_studies.whatif import of_run
from heave_studies.whatif.question import Question

TIME = np.arange(5.0) / 3.0


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    BagWriter(tmp_path / "bag").close({})
    return tmp_path / "bag"


@pytest.fixture
def add(monkeypatch, bag):
    """Add an answer to a record, which it returns; `add.asked` counts how often a record was asked."""

    def ask(source, question, show):
        add.asked += 1
        if add.refuses:
            raise CommandError("bag: the cable was slack")
        return question

    def reconstruction(question):
        bands = {"uncompensated_sigma_m": (0.1, 0.09, 0.11)}
        motions = (Signal(TIME, np.sin(TIME)), Signal(TIME, np.cos(TIME)))
        return Reconstruction(*motions, bands, ["law"], [[one] for one in question.compare], ["line"], [], {"a": 1})

    def add(question=Question("off"), source=ESTIMATED, **options):  # noqa: B008 - it is frozen
        record = RunRecord("run", RunSignals(), 0.0, 1.0, sources={FREE_HEAVE: source})
        add.said = of_run.add_reconstruction(record, bag, question, **options)
        return record

    add.asked, add.refuses = 0, False
    monkeypatch.setattr(of_run, "ask", ask)
    monkeypatch.setattr(of_run, "reconstruction", reconstruction)
    return add


def test_it_is_computed_once_and_what_was_kept_is_the_same_to_the_last_bit(add):
    first, again = add().reconstruction, add(computes=False).reconstruction
    assert add.asked == 1
    assert np.array_equal(again.unit_heave.value, first.unit_heave.value)
    assert np.array_equal(again.uncompensated_heave.time, first.uncompensated_heave.time)
    assert again.bands == first.bands
    assert (again.headings, again.rows, again.lines, again.data) == (
        first.headings,
        first.rows,
        first.lines,
        first.data,
    )


@pytest.mark.parametrize("other", [Question("off", ("industrial",)), Question("off", transient=10.0)])
def test_one_to_another_question_is_not_taken_for_it(add, other):
    add()
    add(other)
    assert add.asked == 2


def test_one_of_another_record_or_of_other_software_is_not_taken_for_it(add, bag, monkeypatch):
    add()
    with next(bag.glob("*.mcap")).open("ab") as file:
        file.write(b"more")
    add()
    monkeypatch.setattr(of_run, "git_commit", lambda: "0" * 40)
    add()
    assert add.asked == 3


@pytest.mark.parametrize(
    "damage",
    [
        lambda text: text[:-40],
        lambda _: "[" * 100_000,
        lambda _: "[]",
        lambda text: json.dumps(json.loads(text) | {"unit_heave": [[1.0], [1.0, 2.0]]}),
        lambda text: json.dumps(json.loads(text) | {"bands": {"unit_efficiency": [1.0]}}),
    ],
)
def test_a_damaged_file_is_computed_anew(add, bag, damage):
    add()
    file = of_run.kept_at(bag)
    file.write_text(damage(file.read_text()))
    assert add().reconstruction is not None
    assert add.asked == 2


def test_a_record_that_cannot_carry_the_answer_says_why_and_has_a_report_all_the_same(add, bag):
    add.refuses = True
    record = add()
    assert record.reconstruction is None
    assert add.said == record.notes == ["what would have been cannot be said: bag: the cable was slack"]
    assert not of_run.kept_at(bag).exists()


@pytest.mark.parametrize(("source", "notes"), [(ESTIMATED, [of_run.OFFER]), (TRUE, []), (RECONSTRUCTED, [])])
def test_it_is_offered_where_there_is_an_estimate_only(add, source, notes):
    record = add(source=source, computes=False)
    assert (record.notes, record.reconstruction, add.asked) == (notes, None, 0)
