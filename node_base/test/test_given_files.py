"""Files that somebody else may have made: they end, and they fit into memory."""

from __future__ import annotations

import gzip
import os
from pathlib import Path

import pytest
from heave_node.files import given_files
from heave_node.files.given_files import read_given


def test_a_file_is_read_and_one_that_is_packed_is_unpacked_whatever_its_name(tmp_path):
    (tmp_path / "own.txt").write_bytes(b"1 2\r\n3 4\n")
    (tmp_path / "own.txt.gz").write_bytes(gzip.compress(b"1 2\r\n") + gzip.compress(b"3 4\n"))
    (tmp_path / "packed.txt").write_bytes(gzip.compress(b"1 2\r\n3 4\n"))
    (tmp_path / "plain.txt.gz").write_bytes(b"1 2\r\n3 4\n")
    for name in ("own.txt", "own.txt.gz", "packed.txt", "plain.txt.gz"):
        assert read_given(tmp_path / name) == b"1 2\r\n3 4\n"


def test_a_file_that_is_larger_than_memory_should_hold_is_refused(tmp_path):
    # ten times what is allowed, in a few hundred kB
    (tmp_path / "own.gz").write_bytes(gzip.compress(bytes(given_files.LARGEST_FILE), 9) * 10)
    with pytest.raises(ValueError, match="larger than"):
        read_given(tmp_path / "own.gz")


def test_what_never_ends_is_not_begun(tmp_path):
    os.mkfifo(tmp_path / "own.csv")
    for path in (tmp_path / "own.csv", Path("/dev/zero"), tmp_path):
        with pytest.raises(ValueError, match="not a file"):
            read_given(path)


@pytest.mark.parametrize(
    "content", [gzip.compress(b"1 2\n" * 100, mtime=0)[:20], b"\x1f\x8b" + bytes(30)], ids=["cut", "foreign"]
)
def test_a_damaged_archive_is_refused(tmp_path, content):
    (tmp_path / "own.gz").write_bytes(content)
    with pytest.raises(ValueError, match="cannot be read to its end"):
        read_given(tmp_path / "own.gz")
