"""The seas of a place and a time from a file, and which of them are workable."""

from __future__ import annotations

import math

import numpy as np
import pandas
import pytest
from heave_node.parameters import ParameterError
from heave_studies.operability.seas import SeaRecord, read_record, workable_share

CURVE = pandas.DataFrame({"period": [6.0, 10.0], "limit": [1.0, 3.0], "lower": [0.5, 2.0], "upper": [1.5, 4.0]})


def test_the_share_of_workable_seas_is_counted_on_the_curve():
    counts = np.array([10, 10, 20, 20, 20, 10, 10])
    heights, periods = [0.8, 0.8, 1.9, 1.9, 1.9, 2.9, 2.9], [4.0, 8.0, 4.0, 8.0, 12.0, 8.0, 12.0]
    record = SeaRecord("seas", pandas.DataFrame({"hs": heights, "tp": periods, "share": counts / 100.0}), math.nan)
    # limits 1 m at 4 s (held), 2 m at 8 s, 3 m at 12 s (held): workable are 10, 10 + 20, 20 + 10 of 100
    assert workable_share(record, CURVE) == pytest.approx(0.7)
    # lower: 0.5, 1.25, 2: 0, 10, 20
    assert workable_share(record, CURVE, "lower") == pytest.approx(0.3)


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.csv", "time,height\n1,2\n", "must have the columns time, hs, tp, not time, height"),
        ("a.csv", "time,hs,tp\nyesterday,1,8\n", "a.csv: "),
        ("a.csv", "time,hs,tp\n2001-01-01,1,8\n", "holds 1 sea states with a height and a period: too few"),
        ("a.csv", "", "is not CSV"),
        ("a.csv", "time,hs,tp\n01.06.2025 00:00,1,8\n01.06.2025 03:00,1,8\n", "'01.06.2025 00:00' is not a time as in"),
        ("a.txt", "no spectra\n", "a.txt"),
    ],
)
def test_what_is_no_record_is_refused_in_one_line(tmp_path, name, text, words):
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(ParameterError) as error:
        read_record(path)
    assert words in str(error.value)
    assert "\n" not in str(error.value)
