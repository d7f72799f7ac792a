"""Tables of cases that somebody else wrote: nothing is written outside the folder of the run, and nothing large."""

from __future__ import annotations

import hashlib
import io
import json
import zipfile
from pathlib import Path

import numpy as np
import pandas
import pyarrow
import pyarrow.parquet
import pytest
from heave_bags.signals import Signal
from heave_bringup.scenarios import shipped_scenarios
from heave_node.parameters import ParameterError
from heave_node.scenario import read_sections, sections_text
from heave_studies.baseline import KEPT, read_kept
from heave_studies.study.case_file import case_in, split_reference, write_case

DIGEST = hashlib.sha256(b"content of a file").hexdigest()
NAMED = "/nowhere/own_rao.csv"


def table(folder: Path, files: object) -> Path:
    """Return a table with one case, which names a file that is not there, and what it says of `files`."""
    sections = read_sections(shipped_scenarios()["unit_1500"])
    sections.setdefault("/**/wave_vessel", {})["vessel.rao_file"] = NAMED
    text = files if isinstance(files, str) else json.dumps(files)
    row = {"case": [1], "scenario": [sections_text(sections)], "files": [text]}
    path = folder / "own.parquet"
    pyarrow.parquet.write_table(pyarrow.Table.from_pandas(pandas.DataFrame(row), preserve_index=False), path)
    return path


def test_a_table_whose_texts_are_no_texts_is_refused_in_a_line(tmp_path):
    wrong = pyarrow.array([b"\xac\xff"]).cast(pyarrow.binary()).view(pyarrow.string())
    arrow = pyarrow.table({"case": pyarrow.array([1]), "scenario": wrong})
    pyarrow.parquet.write_table(arrow, tmp_path / "own.parquet")
    with pytest.raises(ParameterError, match="cannot be read as a table of cases"):
        case_in(tmp_path / "own.parquet", 1)


@pytest.mark.parametrize(
    "files",
    [
        *("7", "[]", "{", "[" * 100_000, {NAMED: 7}, {NAMED: {"sha256": DIGEST}}, {NAMED: {"bytes": 17}}),
        *({NAMED: {"sha256": wrong, "bytes": 17}} for wrong in ("../../up", DIGEST[:-1], DIGEST.upper(), 7, None)),
        *({NAMED: {"sha256": DIGEST, "bytes": wrong}} for wrong in ("17", None, True, 1.5)),
    ],
)
def test_the_files_of_a_case_have_path_digest_and_size(tmp_path, files):
    with pytest.raises(ParameterError, match="case 1: its files are damaged") as told:
        write_case(f"{table(tmp_path, files)}:1", tmp_path / "run.yaml")
    assert "\n" not in str(told.value)
    assert not (tmp_path / "run.yaml").exists()


def test_a_copy_that_is_not_what_the_table_says_is_not_read(tmp_path):
    copy = tmp_path / "files" / DIGEST[:12] / "own_rao.csv"
    copy.parent.mkdir(parents=True)
    copy.write_bytes(b"another content.")
    with pytest.raises(ParameterError, match=r"is not there .* no copy of it"):
        write_case(f"{table(tmp_path, {NAMED: {'sha256': DIGEST, 'bytes': 17}})}:1", tmp_path / "run.yaml")


def test_a_file_that_the_table_names_is_read_only_where_its_size_is_right(tmp_path, monkeypatch):
    import heave_studies.study.case_file as module  # noqa: PLC0415

    other = tmp_path / "large.csv"
    other.write_bytes(bytes(1000))
    monkeypatch.setattr(module, "digest_of", lambda _: pytest.fail("it was read"))
    for path in (str(other), "/dev/zero", "/"):
        assert module.ReadFile(Path(path), DIGEST, 999).state()


def test_a_table_of_other_types_is_refused(tmp_path):
    path = tmp_path / "own.parquet"
    for row in ({"case": ["a"], "scenario": ["b"]}, {"case": [1], "scenario": [[1]]}, {"case": [1], "scenario": [7]}):
        pyarrow.parquet.write_table(pyarrow.table(row), path)
        with pytest.raises(ParameterError, match="not a table of heave study"):
            write_case(f"{path}:1", tmp_path / "run.yaml")


def test_a_case_has_a_number_that_can_be_one():
    assert split_reference("own.parquet:12") == (Path("own.parquet"), 12)
    assert split_reference("own.parquet:" + "9" * 5000) is None


@pytest.mark.parametrize("shape", [(2,), (3, 4), (2, 3, 4), ()])
def test_a_kept_baseline_of_another_shape_is_none(tmp_path, shape):
    path = tmp_path / "own.npz"
    np.savez(path, digest=np.array("d"), lost=np.array(""), **dict.fromkeys(KEPT, np.zeros((2, 5))))
    assert isinstance(read_kept(path, "d").unit_heave, Signal)
    np.savez(path, digest=np.array("d"), lost=np.array(""), **dict.fromkeys(KEPT, np.zeros(shape)))
    assert read_kept(path, "d") is None


def test_a_kept_baseline_that_promises_more_than_it_holds_is_none(tmp_path):
    # the head of a column promises 8 TB, the file has a few bytes
    header = io.BytesIO()
    shape = {"descr": "<f8", "fortran_order": False, "shape": (2, 10**12)}
    np.lib.format.write_array_header_1_0(header, shape)
    path = tmp_path / "own.npz"
    np.savez(path, digest=np.array("d"))
    with zipfile.ZipFile(path, "a") as archive:
        for name in KEPT:
            archive.writestr(f"{name}.npy", header.getvalue())
    assert read_kept(path, "d") is None
