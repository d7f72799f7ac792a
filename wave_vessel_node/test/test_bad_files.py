"""Whatever happens to a file, it is either read into numbers that make sense or refused with one line that names it."""

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from wave_vessel_node.sea.spectrum_files import SpectrumFileError, read_spectra
from wave_vessel_node.sea.spectrum_record import objection_to
from wave_vessel_node.sources.recording import RecordingError, read_recording
from wave_vessel_node.vessel.rao import RaoError, response_questions
from wave_vessel_node.vessel.rao_files import COLUMNS, read_rao, read_rao_csv

DATA = Path(__file__).parent / "data"
FRAGMENTS = st.sampled_from(
    ["", "nan", "-1.0", "99.00", "999.0", "inf", "1e400", "0.0a47", "(", ")", "\n", ",", " ", "#", "--", "\t"]
)
SETTINGS = settings(max_examples=120, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
MOTIONS = ",".join(["0.9", "0.5"] * 3 + ["0.02", "-1.5"] * 3)
RAO = "\n".join(
    [
        ",".join(COLUMNS),
        *(f"0,{h},{w},{MOTIONS}" for h in (0.0, 1.5, 3.14159) for w in (0.2, 0.5, 1.0, 2.0)),
    ]
)
RECORDING = "time_s,z_m\n" + "".join(f"{0.1 * i:.1f},{np.sin(0.1 * i):.4f}\n" for i in range(60))


@st.composite
def damaged(draw, text):
    """Replace up to three pieces of a text by fragments, and cut it somewhere now and then."""
    for _ in range(draw(st.integers(1, 3))):
        start = draw(st.integers(0, max(0, len(text) - 1)))
        length = draw(st.integers(0, 12))
        text = text[:start] + draw(FRAGMENTS) + text[start + length :]
    if draw(st.booleans()):
        text = text[: draw(st.integers(0, len(text)))]
    return text


@st.composite
def mistreated(draw, text):
    """Return a table as another tool would have saved it: units, columns, lines or encoding are not what they were."""
    separator = "," if "," in text else " "
    lines = text.splitlines()
    if draw(st.booleans()):  # a column in another unit
        column = draw(st.integers(0, len(lines[-1].split(separator)) - 1))
        factor = draw(st.sampled_from([1e-3, 0.01, 0.1592, 57.2958, 100.0, 1e3, -1.0]))
        lines = [lines[0], *(separator.join(_scaled(line.split(separator), column, factor)) for line in lines[1:])]
    if draw(st.booleans()):  # columns exchanged under the same headings
        order = draw(st.permutations(range(len(lines[-1].split(separator)))))
        rows = [line.split(separator) for line in lines[1:]]
        lines = [lines[0], *(separator.join([row[i] for i in order if i < len(row)]) for row in rows)]
    for _ in range(draw(st.integers(0, 2))):  # lines cut short
        at = draw(st.integers(0, len(lines) - 1))
        lines[at] = lines[at][: draw(st.integers(0, len(lines[at])))]
    whole = "\n".join(lines) + "\n"
    if draw(st.booleans()):
        whole = whole.replace(".", ",").replace(separator, draw(st.sampled_from([";", "\t", "  "])))
    return whole.encode(draw(st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "latin-1"])), "replace")


def _scaled(cells, column, factor):
    def scaled(cell):
        try:
            return f"{factor * float(cell):g}"
        except ValueError:
            return cell

    return [scaled(cell) if index == column else cell for index, cell in enumerate(cells)]


def refused_or(error, path, read):
    """Return what `read` gives, or None when it refuses in one line that names the file."""
    try:
        return read(path)
    except error as refusal:
        assert path.name in str(refusal)
        assert "\n" not in str(refusal)
        return None


def is_a_sea(file):
    for record in file.records:
        values = np.asarray(record.spectrum.values)
        assert np.isfinite(values).all()
        assert (values >= 0.0).all()
        assert record.spectrum.significant_wave_height > 0.0
        assert objection_to(record.spectrum) == ""


def is_a_ship(table):
    assert np.isfinite(table.at([0.1, 0.7, 5.0], 1.0)).all()
    assert response_questions(table) == []


def is_a_motion(recording):
    assert np.isfinite(recording.position).all()
    assert (np.diff(recording.time) > 0.0).all()
    assert 4.0 * recording.position[:, 2].std() <= 25.0


SEA = (SpectrumFileError, read_spectra, is_a_sea)
FILES = {
    "real_time.data_spec": ((DATA / "real_time.data_spec").read_text(), *SEA),
    "historical.txt": ((DATA / "historical.txt").read_text(), *SEA),
    "rao.csv": (RAO, RaoError, read_rao_csv, is_a_ship),
    "motion.csv": (RECORDING, RecordingError, read_recording, is_a_motion),
}
"""Content of each file, what refuses it, what reads it, and what holds for what was read."""


def check(name, content, tmp_path):
    _, error, read, holds = FILES[name]
    path = tmp_path / name
    path.write_bytes(content)
    found = refused_or(error, path, read)
    if found is not None:
        holds(found)


@pytest.mark.parametrize("name", FILES)
@given(data=st.data())
@SETTINGS
def test_damaged_files(name, data, tmp_path):
    check(name, data.draw(damaged(FILES[name][0])).encode(), tmp_path)


@pytest.mark.parametrize("name", ["historical.txt", "rao.csv", "motion.csv"])
@given(data=st.data())
@SETTINGS
def test_tables_in_other_units_orders_and_encodings(name, data, tmp_path):
    check(name, data.draw(mistreated(FILES[name][0])), tmp_path)


@pytest.mark.parametrize(
    ("read", "name"), [(read_rao, "own.csv"), (read_recording, "own.csv"), (read_spectra, "own.txt")]
)
def test_a_pipe_is_no_file(tmp_path, read, name):
    os.mkfifo(tmp_path / name)  # to read it would wait for ever
    with pytest.raises(ValueError, match=r"no such file|not a file"):
        read(tmp_path / name)
