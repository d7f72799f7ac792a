"""Signals on one time base, and the files that take them."""

import math
import re
from pathlib import Path

import numpy as np
import pandas
import pytest
from heave_bags.analyse import time_base
from heave_bags.analyse.analysis import save_frame
from heave_bags.analyse.read_run import read_run
from heave_bags.errors import BagError
from heave_bags.mcap.reader import Bag
from made_up_run import MadeUpRun

RUN = MadeUpRun()


def test_numbers_are_linear_between_samples_and_codes_and_texts_keep_their_value():
    slow = np.arange(0.0, 11.0)
    samples = {
        "fast": (np.arange(0.0, 10.01, 0.5), np.arange(0.0, 10.01, 0.5)),
        "slow": (slow, 3.0 * slow),
        "code": (slow, np.arange(11)),
        "word": (np.array([2.0, 4.0]), np.array(["a", "b"], dtype=object)),
    }
    frame = time_base.on_one_time_base(samples)
    assert list(frame.index) == [0.5 * n for n in range(21)]
    assert frame["slow"].tolist() == pytest.approx([1.5 * n for n in range(21)])
    assert frame["code"].tolist() == [n // 2 for n in range(21)]
    assert frame["word"].tolist() == [""] * 4 + ["a"] * 4 + ["b"] + [""] * 12


def test_a_gap_and_the_time_outside_a_signal_stay_empty():
    time = np.concatenate([np.arange(0.0, 10.0), np.arange(20.0, 31.0)])
    samples = {"held": (np.arange(0.0, 41.0), np.zeros(41)), "broken": (time, time)}
    broken = time_base.on_one_time_base(samples)["broken"]
    assert broken[:9.0].tolist() == list(range(10))
    assert broken[10.0:19.0].isna().all()
    assert broken[31.0:].isna().all()


def test_a_table_begins_where_all_have_begun_and_what_begins_much_later_is_empty_until_then():
    """States of the winch are stamped a tick later than those of the cable."""
    samples = {
        "cable": (np.arange(0.0, 10.01, 0.5), np.arange(21.0)),
        "winch": (np.arange(0.5, 10.51, 0.5), np.arange(21.0)),
        "usbl": (np.arange(4.0, 10.01, 0.5), np.arange(13.0)),
    }
    frame = time_base.on_one_time_base(samples)
    assert (frame.index[0], frame.index[-1]) == (0.5, 10.0)
    assert frame[["cable", "winch"]].notna().all(axis=None)
    assert frame["usbl"].isna().sum() == 7


def test_stamps_of_any_order_and_kind_are_put_in_order():
    time = np.array([1.0, 0.0, math.nan, 1.0, 2.0, math.inf])
    frame = time_base.on_one_time_base({"x": (time, np.array([5.0, 0.0, 9.0, 1.0, 2.0, 9.0]))})
    assert frame["x"].tolist() == [0.0, 1.0, 2.0]
    with pytest.raises(BagError, match="no sample with a time"):
        time_base.on_one_time_base({"x": (np.array([math.nan]), np.zeros(1))})


def test_a_table_that_stamps_of_two_clocks_would_make_is_refused():
    samples = {"simulated": (np.arange(100.0), np.zeros(100)), "host": (1.7e9 + np.arange(100.0), np.zeros(100))}
    with pytest.raises(BagError, match=r"1\.7e\+09 rows.* --topics of one clock"):
        time_base.on_one_time_base(samples)


def test_the_signals_of_a_run_are_those_of_its_motions(shared_bag):
    frame = time_base.on_one_time_base(time_base.run_samples(read_run(shared_bag)), 0.1)
    time = np.asarray(frame.index)
    assert np.allclose(np.diff(time), 0.1)
    inner = (time > 5.0) & (time < 55.0)
    assert frame["boom_tip_heave_m"][inner].max() == pytest.approx(RUN.boom_tip, abs=0.1)
    assert frame["unit_heave_m"][inner].abs().max() == pytest.approx(RUN.unit, abs=0.02)
    assert frame["top_tension_n"][inner].mean() == pytest.approx(RUN.mean_tension, rel=1e-2)
    assert set(frame["mode"][inner]) <= {"standby", "compensating", ""}


def test_every_number_of_a_topic_is_a_column(shared_bag):
    samples = time_base.topic_samples(Bag(shared_bag), ["winch/state", "/winch/state", "boom_tip"])
    assert {"winch/state.payout", "winch/state.brake", "boom_tip.position.z"} <= set(samples)
    assert not any(name.endswith("log_time") for name in samples)
    with pytest.raises(BagError, match="no topic nothing"):
        time_base.topic_samples(Bag(shared_bag), ["nothing"])


def test_the_page_of_the_package_names_the_columns_of_the_table_and_no_other():
    page = (Path(__file__).parents[1] / "README.md").read_text()
    rows = page[page.index("| column | unit") :].split("\n\n", 1)[0].splitlines()[2:]
    named = [name for row in rows for name in re.findall(r"`(\w+)`", row.split("|")[1])]
    assert named == ["time_s", *time_base.COLUMNS, "mode"]


@pytest.mark.parametrize("ending", ["csv", "parquet", "xlsx"])
def test_a_file_gives_back_what_it_took_and_no_text_becomes_a_formula(tmp_path, ending):
    frame = pandas.DataFrame({"=cmd": [1.25, math.nan, 3.5], "mode": ["=1+1", "@x", "off"]}, index=[0.0, 0.05, 0.1])
    frame.index.name = "time_s"
    path = tmp_path / f"table.{ending}"
    if ending == "xlsx":
        pytest.importorskip("xlsxwriter")
        pytest.importorskip("openpyxl")
    save_frame(frame, path, pandas.DataFrame({"column": ["mode"], "meaning": ["=1+1"]}))
    if ending == "xlsx":
        assert pandas.read_excel(path, sheet_name="columns")["meaning"].tolist() == ["'=1+1"]
    else:
        assert pandas.read_csv(tmp_path / "table_columns.csv")["meaning"].tolist() == ["'=1+1"]
    if ending == "parquet":
        assert pandas.read_parquet(path).equals(frame.reset_index()), "time is a column for every reader of Parquet"
        return
    read = pandas.read_csv(path) if ending == "csv" else pandas.read_excel(path)
    assert list(read.columns) == ["time_s", "'=cmd", "mode"]
    assert read["mode"].tolist() == ["'=1+1", "'@x", "off"]
    assert read["'=cmd"].tolist() == pytest.approx([1.25, math.nan, 3.5], nan_ok=True)


def test_a_sheet_of_too_many_rows_is_refused_in_a_line(tmp_path):
    frame = pandas.DataFrame({"x": np.zeros(1_048_576)})
    with pytest.raises(BagError, match=r"1048576 rows do not fit a sheet of 1048575: take \.csv or \.parquet"):
        save_frame(frame, tmp_path / "table.xlsx")
