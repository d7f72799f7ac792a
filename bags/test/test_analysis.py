"""From a bag to figures of merit: closed forms of a run made of sines."""

import json
import math
import sys

import pandas
import pytest
from heave_bags.analyse import analysis
from heave_bags.errors import BagError
from made_up_run import MadeUpRun

RUN = MadeUpRun()
ROOT = math.sqrt(2.0)


@pytest.fixture(scope="module")
def record(shared_bag):
    """Return the made-up run as analysed: 10 s to 60 s, 6.25 periods."""
    return analysis.analyse([shared_bag])[0]


def test_the_window_is_what_the_bag_says(record):
    assert (record.start, record.end) == (10.0, pytest.approx(60.0))


def test_kpis_over_whole_periods_are_those_of_sines(record):
    values = record.kpis(12.0, 12.0 + 5 * RUN.period - RUN.tick)
    assert values["unit_sigma_m"] == pytest.approx(RUN.unit / ROOT)
    assert values["uncompensated_sigma_m"] == pytest.approx(RUN.uncompensated / ROOT)
    assert values["unit_efficiency"] == pytest.approx(1.0 - RUN.unit / RUN.uncompensated)
    assert values["outlet_efficiency"] == pytest.approx(RUN.payout)
    assert values["tension_mean_n"] == pytest.approx(RUN.mean_tension)
    assert values["tension_max_n"] == pytest.approx(RUN.mean_tension + RUN.tension)
    assert values["winch_speed_max_mps"] == pytest.approx(RUN.payout * RUN.omega)
    assert values["slack_percent"] == 0.0


def test_limits_modes_alarms_and_innovations_are_found(record):
    values = record.kpis()
    assert values["time_at_limit_percent"] == pytest.approx(
        100.0 * 2.0 / 50.0, rel=0.01
    )  # 20 s to 22 s of 10 s to 60 s
    assert [(i.name, round(i.start, 2)) for i in record.modes] == [("standby", 0.05), ("compensating", 5.0)]
    alarms = {(alarm.name, alarm.level): (round(alarm.start, 2), round(alarm.end, 2)) for alarm in record.alarms}
    assert alarms["mru lost", 2] == (30.0, 31.0)
    assert alarms["cable_sim: cable: touches ground", 1] == (40.0, 43.0)
    assert {innovation.name for innovation in record.innovations} == {"mru", "depth"}
    assert values["nis_in_band_percent"] == pytest.approx(100.0 * 2.0 / 3.0, abs=0.1)


def test_limits_of_the_winch_come_from_the_scenario_where_the_nodes_could_say_nothing(record):
    """The bag of a recorder that was killed: what ship and controller share stands under /**, the rest wins over it."""
    assert (record.signals.speed_limit, record.signals.acceleration_limit) == (2.0, 1.5)


def test_a_driven_run_gets_its_harmonics(record):
    values = record.kpis()
    assert values["unit_heave_amplitude_m"] == pytest.approx(RUN.unit)
    assert values["unit_heave_phase_deg"] == pytest.approx(0.0, abs=1e-6)
    assert values["top_tension_amplitude_n"] == pytest.approx(RUN.tension)


def test_extremes_have_the_time_at_which_they_were(record):
    found = {extreme.name: extreme for extreme in analysis.extremes(record)}
    largest = found["top tension, largest"]
    assert largest.value == pytest.approx(RUN.mean_tension + RUN.tension)
    assert math.sin(RUN.omega * largest.time) == pytest.approx(1.0)


def test_windows_cover_the_run(record):
    parts = analysis.windows(record, 8.0)
    assert len(parts) == 7
    assert [part.start for part in parts] == pytest.approx([8.0 * n for n in range(7)], abs=1e-6)
    assert [part.end for part in analysis.windows(record, 20.0)] == pytest.approx([20.0, 40.0, 60.0])
    with pytest.raises(BagError, match="positive length"):
        analysis.windows(record, 0.0)


def test_windows_are_listed_one_a_line(record):
    lines = analysis.window_table(record, 2 * RUN.period).splitlines()
    assert len(lines) == 2 + 3 + 1  # the name, the heading, three times two waves in 60 s, and what is left out
    assert lines[-1] == "left out: the last 12.00 s, shorter than a window of 16 s"
    assert "left out" not in analysis.window_table(record, 20.0)
    start, end, sigma = (float(cell) for cell in lines[3].split()[:3])
    assert end - start == pytest.approx(2 * RUN.period)
    assert sigma == pytest.approx(100.0 * RUN.unit / ROOT, rel=0.01)


def test_json_is_plain_and_has_no_nan(record):
    text = json.dumps(analysis.to_json(record, window=20.0), allow_nan=False)
    content = json.loads(text)
    assert content["real_time_factor"] == 50.0
    assert content["kappa"] is None
    assert len(content["windows"]) == 3


def test_tables_are_written_as_csv_and_parquet(record, tmp_path):
    frame = analysis.kpi_frame([record], window=20.0)
    analysis.save_frame(frame, tmp_path / "kpis.csv")
    back = pandas.read_csv(tmp_path / "kpis.csv")
    assert back["unit_sigma_m"].tolist() == pytest.approx(frame["unit_sigma_m"].tolist())
    with pytest.raises(BagError, match=r"\.csv or \.parquet"):
        analysis.save_frame(frame, tmp_path / "kpis.txt")
    with pytest.raises(BagError, match=r"kpis\.csv: the table cannot be written"):
        analysis.save_frame(frame, tmp_path / "nowhere" / "kpis.csv")


def test_parquet_needs_a_package_that_is_named(record, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    monkeypatch.setitem(sys.modules, "fastparquet", None)
    with pytest.raises(BagError, match="pip install pyarrow"):
        analysis.save_frame(analysis.kpi_frame([record]), tmp_path / "kpis.parquet")


def test_runs_are_compared_side_by_side(made_up_bag):
    paths = [made_up_bag("good", MadeUpRun(unit=0.05)), made_up_bag("bad", MadeUpRun(unit=0.2))]
    lines = analysis.table(analysis.analyse(paths)).splitlines()
    assert lines[0].split() == ["good", "bad"]
    assert next(line for line in lines if line.startswith("unit heave, first harmonic")).split()[-3:-1] == [
        "0.05000",
        "0.20000",
    ]


def test_a_bag_of_others_is_refused_with_what_it_has(tmp_path):
    from heave_bags.mcap.bag_writer import BagWriter  # noqa: PLC0415

    writer = BagWriter(tmp_path / "bag")
    writer.add_topic("/chatter", "std_msgs/msg/String")
    writer.write("/chatter", 1, b"\x00\x01\x00\x00\x02\x00\x00\x00a\x00")
    writer.close()
    with pytest.raises(BagError, match="none of the topics of a run is in it; it has /chatter"):
        analysis.analyse([tmp_path / "bag"])
