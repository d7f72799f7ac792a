"""Tables of text in all forms, and what is none."""

import gzip

import pytest
from heave_node.files.columns import ColumnsError, read_columns
from heave_node.files.given_files import TextFileError, read_text
from hypothesis import given
from hypothesis import strategies as st

NUMBERS = st.lists(
    st.tuples(st.floats(-1e4, 1e4).map(lambda x: round(x, 3)), st.floats(-1e4, 1e4).map(lambda x: round(x, 3))),
    min_size=5,
    max_size=40,
)


@given(
    NUMBERS, st.sampled_from([(",", "."), (";", "."), (";", ","), ("\t", "."), ("\t", ","), ("   ", "."), (" ", ",")])
)
def test_rows_are_read_back_whatever_separator_and_decimal_sign(rows, form):
    separator, point = form
    lines = ["depth heave".replace(" ", separator)]
    lines += [separator.join(f"{value:.3f}".replace(".", point) for value in row) for row in rows]
    table = read_columns(lines)
    assert table.header == ["depth", "heave"]
    assert [tuple(table.number(cell) for cell in row) for row in table.rows] == rows
    assert table.lines == list(range(2, len(lines) + 1))


def test_units_preamble_and_comments_are_known():
    lines = ["Ship,MV Example,x", "# note", "time,heave", "s,[m]", "0.0,1.0", "# more", "1.0,2.0", "2.0,3.0"]
    table = read_columns(lines)
    assert (table.header, table.header_line, table.units) == (["time", "heave"], 3, ["s", "[m]"])
    assert table.lines == [5, 7, 8]
    assert len(table.notes) == 2


@pytest.mark.parametrize(
    ("lines", "says"),
    [
        ([], "is empty"),
        (["# a", "", "#b"], "2 lines, all begin with #"),
        (["a,b"], "no rows"),
        (["1,2", "3,4"], "no line of headings"),
    ],
)
def test_what_is_no_table_is_refused(lines, says):
    with pytest.raises(ColumnsError, match=says):
        read_columns(lines)


@given(st.text(max_size=300))
def test_any_text_is_a_table_or_refused(text):
    try:
        table = read_columns(text.splitlines())
    except ColumnsError as error:
        assert "\n" not in str(error)
    else:
        assert len(table.rows) == len(table.lines)


@pytest.mark.parametrize(
    ("data", "lines", "note"),
    [
        ("a,°\n1,2\n".encode(), ["a,°", "1,2"], ""),
        ("a,°\n".encode("utf-8-sig"), ["a,°"], ""),
        ("a,°\n".encode("utf-16"), ["a,°"], "UTF-16"),
        ("a,°\n".encode("latin-1"), ["a,°"], "Latin-1"),
        (gzip.compress(b"a,b\n", mtime=0), ["a,b"], ""),
        (b"a,b\n" + bytes(9), ["a,b"], "9 zero bytes"),
    ],
)
def test_text_of_any_encoding_is_read(tmp_path, data, lines, note):
    (tmp_path / "a.txt").write_bytes(data)
    text = read_text(tmp_path / "a.txt")
    assert text.lines == lines
    assert any(note in said for said in text.notes) or not note


@given(st.binary(max_size=200))
def test_any_file_is_text_or_refused_with_its_name(tmp_path_factory, data):
    path = tmp_path_factory.getbasetemp() / "any.txt"
    path.write_bytes(data)
    try:
        read_text(path)
    except TextFileError as error:
        assert str(path) in str(error)
        assert "\n" not in str(error)
