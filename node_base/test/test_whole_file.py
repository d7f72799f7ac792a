"""A file is written whole or not at all."""

import os
from pathlib import Path

import pytest
from heave_node.files.given_files import whole_file


def test_the_old_file_stays_until_the_new_one_is_whole_and_nothing_else_is_left(tmp_path):
    path = tmp_path / "kept.json"
    with whole_file(path) as unfinished:
        unfinished.write_text("one")
    with pytest.raises(OSError, match="no space"), whole_file(path) as unfinished:
        unfinished.write_text("half")
        assert path.read_text() == "one"
        raise OSError("no space")
    assert [one.name for one in tmp_path.iterdir()] == ["kept.json"]
    assert path.read_text() == "one"


def test_a_refusal_of_the_system_has_the_name_of_the_file(tmp_path):
    with pytest.raises(OSError, match="No space") as refused, whole_file(tmp_path / "kept.json"):
        raise OSError(28, "No space left on device")
    assert refused.value.filename == str(tmp_path / "kept.json")


def test_a_device_and_a_link_stay_what_they_are(tmp_path):
    with pytest.raises(OSError, match="No space"), whole_file(Path("/dev/full")) as place:
        place.write_text("x")
    assert Path("/dev/full").is_char_device()
    os.mkfifo(tmp_path / "pipe")
    with whole_file(tmp_path / "pipe") as place:
        assert place == tmp_path / "pipe"
    assert (tmp_path / "pipe").is_fifo()
    (tmp_path / "link").symlink_to(tmp_path / "file")
    with whole_file(tmp_path / "link") as place:
        place.write_text("x")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "file").read_text() == "x"
