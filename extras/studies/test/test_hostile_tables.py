"""Tables of cases that somebody else wrote: nothing is written outside the folder of the run, and nothing large."""

from __future__ import annotations

import base64
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
from heave_studies.study.case_file import FILE_MARK, files_of, read_cases, scenario_of, split_reference, write_case

CONTENT = b"content of a file"
DIGEST = hashlib.sha256(CONTENT).hexdigest()
ENTRY = "own.csv"


def packed(*members: tuple[str, bytes]) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members:
            archive.writestr(name, content)
    return buffer.getvalue()


GOOD = {"name": ENTRY, "size": len(CONTENT), "zip": base64.b64encode(packed((ENTRY, CONTENT))).decode()}


def table(folder: Path, key: str = DIGEST, content: object = GOOD, files: str = "") -> Path:
    """Return a table with one case, which names a file that is not there, and what it keeps for it."""
    named = "/nowhere/own_rao.csv"
    sections = read_sections(shipped_scenarios()["unit_1500"])
    sections.setdefault("/**/wave_vessel", {})["vessel.rao_file"] = named
    row = {"case": [1], "scenario": [sections_text(sections)], "files": [files or json.dumps({named: key})]}
    arrow = pyarrow.Table.from_pandas(pandas.DataFrame(row), preserve_index=False)
    value = content if isinstance(content, bytes) else json.dumps(content).encode()
    arrow = arrow.replace_schema_metadata({FILE_MARK + key.encode(): value})
    path = folder / "own.parquet"
    pyarrow.parquet.write_table(arrow, path)
    return path


def written(folder: Path) -> list[str]:
    return [one.name for one in folder.rglob("*") if one.name not in ("own.parquet", "run_files")]


def test_what_a_table_keeps_is_written_into_the_folder_of_the_run(tmp_path):
    _, (line,) = write_case(f"{table(tmp_path)}:1", tmp_path / "run.yaml")
    assert "is not there" in line
    (path,) = (tmp_path / "run_files").rglob(ENTRY)
    assert path.read_bytes() == CONTENT


def test_a_table_whose_texts_are_no_texts_is_refused_in_a_line(tmp_path):
    wrong = pyarrow.array([b"\xac\xff"]).cast(pyarrow.binary()).view(pyarrow.string())
    arrow = pyarrow.table({"case": pyarrow.array([1]), "scenario": wrong})
    pyarrow.parquet.write_table(arrow, tmp_path / "own.parquet")
    with pytest.raises(ParameterError, match="cannot be read as a table of cases"):
        scenario_of(tmp_path / "own.parquet", 1)


@pytest.mark.parametrize(
    "key", ["../../up", "/tmp/own", "a", "." * 64, DIGEST.upper(), DIGEST + "/..", DIGEST[:63] + "\n"]
)
def test_a_digest_is_64_hex_digits(tmp_path, key):
    with pytest.raises(ParameterError, match="digest"):
        write_case(f"{table(tmp_path, key)}:1", tmp_path / "run.yaml")
    assert not written(tmp_path)


@pytest.mark.parametrize(
    "name", ["", ".", "..", "../up", "/tmp/own", "a/b", "a\\b", "a\0b", "a\nb", "x" * 300, 7, None]
)
def test_a_kept_file_has_a_plain_name(tmp_path, name):
    with pytest.raises(ParameterError):
        write_case(f"{table(tmp_path, content={**GOOD, 'name': name})}:1", tmp_path / "run.yaml")
    assert not written(tmp_path)


@pytest.mark.parametrize("size", [-1, 1e3, "17", None, True, 10**12, 16])
def test_a_kept_file_is_as_large_as_the_table_says(tmp_path, size):
    with pytest.raises(ParameterError):
        write_case(f"{table(tmp_path, content={**GOOD, 'size': size})}:1", tmp_path / "run.yaml")
    assert not written(tmp_path)


@pytest.mark.parametrize(
    "members",
    [
        [("../own.csv", CONTENT)],
        [("/tmp/own.csv", CONTENT)],
        [(ENTRY, CONTENT), ("other.csv", b"")],
        [(ENTRY, CONTENT), (ENTRY, CONTENT)],
        [(f"{ENTRY}/../../up.csv", CONTENT)],
        [(ENTRY, CONTENT[:-1]), (f"{ENTRY}/x", CONTENT[-1:])],
        [(ENTRY, bytes(len(CONTENT)))],
        [(ENTRY, bytes(100_000_000))],
        [],
    ],
)
def test_an_archive_holds_what_its_digest_says_and_else_nothing_is_written(tmp_path, members):
    content = {**GOOD, "zip": base64.b64encode(packed(*members)).decode()}
    with pytest.raises(ParameterError):
        write_case(f"{table(tmp_path, content=content)}:1", tmp_path / "run.yaml")
    assert not written(tmp_path)
    assert not Path("/tmp/own.csv").exists()


@pytest.mark.parametrize(
    "content",
    [b"", b"[]", b"7", b"\xff\xfe", b"[" * 100_000, b'{"name": "a"}', b'{"size": 1' + b"0" * 5000 + b"}"]
    + [{**GOOD, "zip": text} for text in ("!!", "é", 7, None, "AAAA", GOOD["zip"][:40])],
)
def test_metadata_that_is_no_file_is_refused_in_one_line(tmp_path, content):
    with pytest.raises(ParameterError) as told:
        write_case(f"{table(tmp_path, content=content)}:1", tmp_path / "run.yaml")
    assert "\n" not in str(told.value)
    assert not written(tmp_path)


@pytest.mark.parametrize("files", ["7", "[]", '{"/nowhere/own_rao.csv": 7}', "{", "[" * 100_000, '{"a": "../x"}'])
def test_the_files_of_a_case_are_digests_by_path(tmp_path, files):
    with pytest.raises(ParameterError, match="case 1"):
        write_case(f"{table(tmp_path, files=files)}:1", tmp_path / "run.yaml")


def test_a_file_that_the_table_names_is_read_only_where_its_size_is_right(tmp_path, monkeypatch):
    import heave_studies.study.case_file as module  # noqa: PLC0415

    other = tmp_path / "large.csv"
    other.write_bytes(bytes(1000))
    monkeypatch.setattr(module, "digest_of", lambda _: pytest.fail("it was read"))
    kept = {DIGEST: module.KeptFile("large.csv", DIGEST, 999, b"")}
    for path in (str(other), "/dev/zero", "/"):
        with pytest.raises(ParameterError, match=r"too large for the table|is not there"):
            module.make_good({path: DIGEST}, kept, [path], tmp_path / "run", "own.parquet:1")


def test_a_table_that_unpacks_to_more_than_it_may_is_refused(tmp_path):
    # 100,000 rows of one text of 100 kB are 10 GB, and a few kB in the file
    texts = pyarrow.DictionaryArray.from_arrays(pyarrow.array(np.zeros(100_000, np.int32)), ["x" * 100_000])
    rows = pyarrow.table({"case": np.arange(100_000), "scenario": texts})
    path = tmp_path / "own.parquet"
    pyarrow.parquet.write_table(rows, path, compression="zstd")
    assert path.stat().st_size < 1e6
    for read in (read_cases, lambda path: scenario_of(path, 1), lambda path: files_of(path, 1)):
        with pytest.raises(ParameterError, match="unpacks to"):
            read(path)


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
