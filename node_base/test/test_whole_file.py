"""A file is written whole or not at all."""

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
