"""Text files that somebody else may have made: they end, and they fit into memory."""

from __future__ import annotations

import gzip
import os
from pathlib import Path

import pytest
from heave_node.files import given_files
from heave_node.files.given_files import read_given


def test_a_text_is_read_and_one_that_is_packed_is_unpacked(tmp_path):
    (tmp_path / "own.txt").write_bytes(b"1 2\r\n3 4\n")
    (tmp_path / "own.txt.gz").write_bytes(gzip.compress(b"1 2\r\n3 4\n"))
    assert read_given(tmp_path / "own.txt").splitlines() == ["1 2", "3 4"]
    assert read_given(tmp_path / "own.txt.gz").splitlines() == ["1 2", "3 4"]


def test_a_text_that_is_larger_than_memory_should_hold_is_refused(tmp_path):
    # ten times what is allowed, in a few hundred kB
    (tmp_path / "own.gz").write_bytes(gzip.compress(bytes(given_files.LARGEST_TEXT), 9) * 10)
    with pytest.raises(ValueError, match="larger than"):
        read_given(tmp_path / "own.gz")


def test_what_never_ends_is_not_begun(tmp_path):
    os.mkfifo(tmp_path / "own.csv")
    for path in (tmp_path / "own.csv", Path("/dev/zero"), tmp_path):
        with pytest.raises(ValueError, match="not a file"):
            read_given(path)


@pytest.mark.parametrize("content", [gzip.compress(b"1 2\n" * 100)[:20], b"no archive", b"\x1f\x8b" + bytes(30)])
def test_a_damaged_archive_is_refused(tmp_path, content):
    (tmp_path / "own.gz").write_bytes(content)
    with pytest.raises((ValueError, OSError)):
        read_given(tmp_path / "own.gz")


def test_another_encoding_is_refused(tmp_path):
    (tmp_path / "own.txt").write_bytes(b"\xff\xfe")
    with pytest.raises(ValueError, match="byte 0 is not UTF-8"):
        read_given(tmp_path / "own.txt")
