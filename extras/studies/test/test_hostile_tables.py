"""Tables of cases that somebody else wrote: nothing is written outside the folder of the run, and nothing large."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import numpy as np
import pyarrow
import pyarrow.parquet
import pytest
from heave_bags.signals import Signal
from heave_node.parameters import ParameterError
from heave_studies.baseline import KEPT, read_kept
from heave_studies.study.case_file import case_in, split_reference, write_case


def test_a_table_whose_texts_are_no_texts_is_refused_in_a_line(tmp_path):
    wrong = pyarrow.array([b"\xac\xff"]).cast(pyarrow.binary()).view(pyarrow.string())
    arrow = pyarrow.table({"case": pyarrow.array([1]), "scenario": wrong})
    pyarrow.parquet.write_table(arrow, tmp_path / "own.parquet")
    with pytest.raises(ParameterError, match="cannot be read as a table of cases"):
        case_in(tmp_path / "own.parquet", 1)


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
