"""From a bag to figures of merit: closed forms of a run made of sines."""

import json
import math
import re
import sys

import numpy as np
import pandas
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from foreign_bags import HOST_TIME, by_host_clock, by_simulated_clock, write_foreign
from heave_bags.analyse import analysis, kpi_set, read_run
from heave_bags.analyse.reading.fields import on_one_clock
from heave_bags.errors import BagError
from heave_bags.mcap.bag_writer import BagWriter
from heave_bags.mcap.reader import Bag
from heave_bags.report import report
from heave_node.cdr.definitions import schema_text
from made_up_run import TYPES, MadeUpRun, header, tick_messages, write_run
from rclpy.serialization import serialize_message

RUN = MadeUpRun()
ROOT = math.sqrt(2.0)


@pytest.fixture(scope="module")
def record(shared_bag):
    """Return the made-up run as analysed: 10 s to 60 s, 6.25 periods."""
    return analysis.analyse([shared_bag])[0]


def test_the_window_is_what_the_bag_says(record):
    assert (record.start, record.end) == (10.0, pytest.approx(60.0))


def test_the_largest_strain_is_the_last_that_the_plant_told(record):
    """0.0001 for each second up to the last whole one of the run."""
    assert record.largest_strain == pytest.approx(1e-4 * math.floor(record.end), abs=1.01e-4)


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
    assert alarms["SENSOR_LOST, MRU", 2] == (30.0, 31.0)
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
    assert next(line for line in lines if line.startswith("load heave, first harmonic")).split()[-3:-1] == [
        "5.000",
        "20.00",
    ]


PARAMETERS = {
    "virtual_winch": {"speed_limit": 2.0, "acceleration_limit": 1.5},
    "wave_vessel": {"boom_tip_source": "regular", "period": 8.0},
    "**": {"transient": 10.0},
}


@pytest.mark.parametrize("clock", [by_host_clock, by_simulated_clock])
def test_a_run_has_the_same_figures_to_every_digit_whoever_recorded_it_by_whatever_clock(shared_bag, tmp_path, clock):
    (own,) = analysis.analyse([shared_bag])
    (foreign,) = analysis.analyse([write_foreign(shared_bag, tmp_path / "foreign", clock)], parameters=PARAMETERS)
    assert (foreign.start, foreign.end) == (own.start, own.end)
    for key, value in own.kpis().items():
        if kpi_set.DEFINITION_OF[key].group != kpi_set.TIMING:  # of its timing only the suite's own recorder knows
            assert foreign.kpis()[key] == value or math.isnan(value), key
    assert analysis.kpi_frame([foreign], 20.0)["unit_sigma_m"].equals(analysis.kpi_frame([own], 20.0)["unit_sigma_m"])
    assert [(alarm.name, alarm.start) for alarm in foreign.alarms] == [
        (alarm.name, alarm.start) for alarm in own.alarms
    ]


def test_messages_without_a_stamp_are_put_on_the_clock_of_the_others(tmp_path):
    writer = BagWriter(tmp_path / "bag")
    writer.add_topic("/boom_tip", "heave_msgs/msg/PointMotion")
    writer.add_topic("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray")
    for number in range(1, 401):
        time, host = number * 50_000_000, HOST_TIME + number * 2_000_000
        writer.write("/boom_tip", host, bytes(serialize_message(tick_messages(RUN, time)["/boom_tip"])))
        if number == 200:
            status = DiagnosticStatus(level=DiagnosticStatus.WARN, name="disk", message="nearly full")
            writer.write("/diagnostics", host, bytes(serialize_message(DiagnosticArray(status=[status]))))
    writer.close()
    (record,) = analysis.analyse([tmp_path / "bag"])
    (alarm,) = record.alarms
    assert alarm.start == pytest.approx(10.0, abs=0.05)


def test_a_node_that_reports_seconds_late_takes_no_alarm_out_of_the_report(tmp_path):
    """On a busy computer the adviser was 1.7 s behind: that was taken for a reset, and all alarms before were lost."""
    writer = BagWriter(tmp_path / "bag")
    writer.add_topic("/boom_tip", "heave_msgs/msg/PointMotion")
    writer.add_topic("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray")
    for number in range(1, 401):
        time = number * 50_000_000
        writer.write("/boom_tip", time, bytes(serialize_message(tick_messages(RUN, time)["/boom_tip"])))
        stamps = {100: 5.0, 300: 15.0, 301: 12.0}
        if number in stamps:
            name = "winch_adviser: answers" if number == 301 else f"disk {number}"
            status = DiagnosticStatus(level=DiagnosticStatus.ERROR, name=name, message="nearly full")
            array = DiagnosticArray(header=header(round(1e9 * stamps[number])), status=[status])
            writer.write("/diagnostics", time, bytes(serialize_message(array)))
    writer.close()
    (record,) = analysis.analyse([tmp_path / "bag"])
    assert [alarm.start for alarm in record.alarms if alarm.name.startswith("disk")] == pytest.approx([5.0, 15.0])


def test_stamps_of_hardware_by_its_own_clock_are_read_as_in_the_run():
    """A clock 12,345 s ahead that runs 300 ppm fast; messages come 5 ms after their measurement."""
    log_time = np.arange(1, 2001) * 50_000_000
    measured = log_time * 1e-9 - 0.005
    topics = {
        "/unit/odometry": {"time": log_time * 1e-9, "log_time": log_time},
        "/mru": {"time": measured, "log_time": log_time},
        "/winch/state": {"time": 12_345.0 + (1.0 + 300e-6) * measured, "log_time": log_time},
    }
    on_one_clock(topics)
    assert topics["/winch/state"]["time"] == pytest.approx(measured, abs=0.006), "the least delay cannot be told"
    assert (topics["/mru"]["time"] == measured).all()


def test_the_window_of_a_host_s_clock_begins_a_transient_after_the_record(tmp_path):
    write_run(tmp_path / "bag", offset=HOST_TIME // 50_000_000 * 50_000_000)
    (record,) = analysis.analyse([tmp_path / "bag"])
    assert record.end - record.start == pytest.approx(60.0 - 0.05 - 10.0)
    assert record.kpis()["unit_sigma_m"] > 0.0


def test_a_bag_that_gives_no_figure_at_all_is_an_error(tmp_path):
    writer = BagWriter(tmp_path / "bag")
    writer.add_topic("/controller/state", "heave_msgs/msg/ControllerState")
    message = tick_messages(RUN, 50_000_000)["/controller/state"]
    message.nis = [math.nan]
    writer.write("/controller/state", 50_000_000, bytes(serialize_message(message)))
    writer.close()
    with pytest.raises(BagError, match="no figures can be computed"):
        analysis.analyse([tmp_path / "bag"])


KINDS = ("string", "float64[]", None, "string")


def definitions_of_other_kinds():
    """Yield a topic and its definition with one field of another kind, or gone."""
    selected = {re.split(r"[.\]]", path)[-1] for paths in read_run.SELECTION.values() for path in paths}
    looked_at = {*selected, "sensor", "level", "sec", "nanosec"}
    for name in read_run.SELECTION:
        full = "/" + name.lstrip("/")
        if full not in TYPES:
            continue
        text = schema_text(TYPES[full])
        for field in re.findall(r"^(?:float64|uint32|uint8|int32|bool|string|byte)(?:\[\])? +(\w+)", text, re.M):
            if field not in looked_at:
                continue
            for kind in KINDS[len(field) % 3 :][:2]:
                line = f"{kind} {field}" if kind else ""
                yield full, field, re.sub(rf"^[a-z]+[0-9]*(\[\])? +{field}\b.*$", line, text, flags=re.M)


def test_definitions_of_other_kinds_cost_figures_and_end_in_one_line_at_most(shared_bag, tmp_path):
    """Each field that is looked at is renamed by its absence, or holds what nobody expects there."""
    bag = Bag(shared_bag)
    short = list(bag.messages(end=12_000_000_000))
    seen = 0
    for number, (topic, _, text) in enumerate(definitions_of_other_kinds()):
        folder = tmp_path / str(number)
        writer = BagWriter(folder, run=bag.run)
        for name, known in bag.topics.items():
            writer.add_foreign_topic(known, text if name == topic else known.schema)
        for message in short:
            writer.write(message.topic, message.log_time, message.data)
        writer.close()
        try:
            records = analysis.analyse([folder])
            json.dumps(analysis.to_json(records[0], 5.0), allow_nan=False)
            report.page_content(records, [])
            analysis.table(records)
        except BagError as error:
            assert "\n" not in str(error)
        seen += 1
    assert seen > 40


def test_a_run_without_namespace_is_read_from_a_bag_that_holds_another_runs_topics_too(shared_bag, tmp_path):
    own = Bag(shared_bag)
    writer = BagWriter(tmp_path / "both")
    for prefix in ("", "/spy"):
        for topic in own.topics.values():
            writer.add_topic(prefix + topic.name, topic.type)
    for message in own.messages():
        writer.write(message.topic, message.log_time, message.data)
        writer.write("/spy" + message.topic, message.log_time + 1, message.data)
    writer.close()
    both, alone = (read_run.read_run(path, transient=10.0) for path in (tmp_path / "both", shared_bag))
    assert both.kpis()["unit_sigma_m"] == alone.kpis()["unit_sigma_m"]


def test_a_bag_of_others_is_refused_with_what_it_has(tmp_path):
    writer = BagWriter(tmp_path / "bag")
    writer.add_topic("/chatter", "std_msgs/msg/String")
    writer.write("/chatter", 1, b"\x00\x01\x00\x00\x02\x00\x00\x00a\x00")
    writer.close()
    with pytest.raises(BagError, match="none of a run's topics in it; it holds /chatter"):
        analysis.analyse([tmp_path / "bag"])
