"""`heave whatif` on records of others: a log in columns and a bag with other topics are read as the run's own bag."""

import math
from dataclasses import replace

import numpy as np
import pytest
from heave_bags.mcap.bag_writer import BagWriter
from heave_bags.mcap.reader import Bag
from heave_bringup.errors import CommandError
from heave_msgs.msg import LoadCell, MruSample, WinchState
from heave_studies.whatif.asked import nominal_of
from heave_studies.whatif.fitness import reported, warnings
from heave_studies.whatif.known import learn, off_sigma
from heave_studies.whatif.signals.from_bag import read_record, scenario_text, write_text
from heave_studies.whatif.signals.from_others import read_others
from heave_studies.whatif.study import answers, same_again
from heave_studies.whatif.twin.replay import Asked
from heave_studies.whatif.twin.winch import mean_payout
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import FluidPressure

from tests.campaigns import whatif as campaign
from tests.campaigns.in_process import heave, judge
from tests.campaigns.whatif import Recording, make_draw, scenario_of

TICK = 0.05
HOST = 1_700_000_000
"""Time of the host's clock at the start of a run [s]."""

LOG = """
time_column: unix
heave: {column: heave, unit: cm, positive: down}
heave_rate: {column: heave_rate}
roll: {column: roll, unit: deg}
pitch: {column: pitch, unit: deg}
pressure: {column: pressure, unit: bar}
tension: {column: load, unit: kN}
payout: {column: rope}
payout_rate: {column: speed, unit: m/min}
"""
BAG = """
heave: {topic: /ship/motion, field: heave}
heave_rate: {topic: /ship/motion, field: heave_rate}
roll: {topic: /ship/motion, field: roll}
pitch: {topic: /ship/motion, field: pitch}
pressure: {topic: /rov/pressure, field: fluid_pressure}
tension: {topic: /crane/load, field: tension}
payout: {topic: /crane/drum, field: encoder_payout}
payout_rate: {topic: /crane/drum, field: encoder_payout_rate}
"""
RENAMED = {
    "/mru": ("/ship/motion", MruSample),
    "/unit/pressure": ("/rov/pressure", FluidPressure),
    "/winch/load_cell": ("/crane/load", LoadCell),
    "/winch/state": ("/crane/drum", WinchState),
}


def write_log(record, nominal, path, *, orders=False):
    """Write what the sensors of a record read as a log in other units, rounded as such logs are."""
    rows = {}
    for tick, (given, order) in enumerate(zip(record.measurements, record.orders, strict=True), start=record.first):
        per_metre = nominal.water_density * nominal.gravity
        for one in given.mru:
            rows.setdefault(round(one.time, 3), {}).update(
                heave=f"{-100.0 * one.heave:.2f}",
                heave_rate=f"{one.heave_rate:.4f}",
                roll=f"{math.degrees(one.roll):.3f}",
                pitch=f"{math.degrees(one.pitch):.3f}",
            )
        for one in given.of("depth"):
            rows.setdefault(round(one.time, 3), {})["pressure"] = f"{(101325.0 + per_metre * one.value) / 1e5:.5f}"
        for one in given.of("load_cell"):
            rows.setdefault(round(one.time, 3), {})["load"] = f"{one.value / 1e3:.2f}"
        if given.winch is not None:
            rows.setdefault(round(given.winch.time, 3), {}).update(
                rope=f"{35.0 + given.winch.encoder_payout:.4f}", speed=f"{60.0 * given.winch.encoder_payout_rate:.3f}"
            )
        if orders:
            rows.setdefault(round(tick * TICK, 3), {})["order"] = f"{order.payout_rate:.4f}"
    names = sorted({name for row in rows.values() for name in row})
    lines = [f"{HOST + time:.3f}," + ",".join(rows[time].get(name, "") for name in names) for time in sorted(rows)]
    path.write_text("\n".join(["unix," + ",".join(names), *lines]) + "\n", encoding="utf-8")
    return path


def write_renamed(bag, folder):
    """Write the sensors of a bag under the names and by the clock of somebody else."""
    writer = BagWriter(folder, run={})
    kept = [name for name in bag.topics if name in RENAMED]
    for name in kept:
        writer.add_foreign_topic(replace(bag.topics[name], name=RENAMED[name][0]), bag.topics[name].schema)
    for message in bag.messages(kept):
        name, kind = RENAMED[message.topic]
        content = deserialize_message(message.data, kind)
        content.header.stamp.sec += HOST
        writer.write(name, message.log_time + HOST * 1_000_000_000, serialize_message(content))
    writer.close({})
    return folder


def map_of(folder, text):
    path = folder / "map.yaml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def own(calm_bag, tmp_path_factory):
    nominal, _ = nominal_of(write_text(tmp_path_factory.mktemp("scenario"), scenario_text(Bag(calm_bag))))
    return read_record(Bag(calm_bag), nominal), nominal


@pytest.mark.parametrize("form", ["log", "bag"])
def test_a_record_of_others_is_read_as_the_bag_itself(calm_bag, own, tmp_path, form):
    whole, nominal = own
    if form == "log":
        source, text = write_log(whole, nominal, tmp_path / "log.csv"), LOG
    else:
        source, text = write_renamed(Bag(calm_bag), tmp_path / "bag"), BAG
    found, notes = read_others(source, map_of(tmp_path, text), nominal, TICK)
    assert not [one for one in notes if one.startswith("pressure")], "cells of a slower sensor are blank"
    assert (found.is_own, found.has_orders, found.modes[50]) == (False, False, "")
    assert abs(found.ticks - whole.ticks) <= 2
    # a log does not say when a reading came: it is given when it was taken
    places = {"mru": found.mru, "depth": found.scalar("depth"), "load_cell": found.scalar("load_cell")}
    others = {"mru": whole.mru, "depth": whole.scalar("depth"), "load_cell": whole.scalar("load_cell")}
    for sensor, digit in {"mru": 1e-4, "depth": 2e-4, "load_cell": 6.0}.items():
        count = len(places[sensor])
        assert len(others[sensor]) - 2 <= count <= len(others[sensor])
        assert places[sensor][:, 0] == pytest.approx(others[sensor][:count, 0], abs=1e-3)
        assert places[sensor][:, 1:] == pytest.approx(others[sensor][:count, 1:], abs=digit)
    assert found.encoder == pytest.approx(whole.encoder[: found.ticks], abs=1e-4)


@pytest.mark.parametrize(
    ("column", "sensor", "every"),
    [("heave", "mru", 1), ("pressure", "depth", 1), ("pressure", "depth", 3), ("", "", 3)],
)
def test_a_sensor_that_gave_no_numbers_is_a_loss_with_its_time(own, tmp_path, column, sensor, every):
    # a log of 10 s at least; nothing of the sensor from 4 s to 7 s, and of each depth one of `every`
    whole, nominal = own
    names, *rows = write_log(whole, nominal, tmp_path / "log.csv").read_text().splitlines()
    columns = names.split(",")
    cells, read = [row.split(",") for row in rows], 0
    for row in cells:
        place = columns.index("pressure")
        read += row[place] != ""
        row[place] = row[place] if read % every == 0 else ""
        if column and 4.0 < float(row[0]) - HOST < 7.0:
            row[columns.index(column)] = "NaN"
    (tmp_path / "log.csv").write_text("\n".join([names, *map(",".join, cells)]) + "\n", encoding="utf-8")
    found, _ = read_others(tmp_path / "log.csv", map_of(tmp_path, LOG), nominal, TICK)
    losses = [(one.sensor, round(one.end - one.start)) for one in found.losses if one.end - one.start > 1.0]
    assert losses == ([(sensor, 3)] if column else [])


@pytest.mark.parametrize(
    ("right", "wrong", "words"),
    [
        ("unit: kN", "unit: tf", "tension over the weight of cable and unit is 9.8"),
        ("unit: kN", "unit: N", "tension over the weight of cable and unit is 0.001"),
        ("unit: bar", "unit: kPa", "depth by pressure over the cable that is out is -0.0"),
        ("column: heave, unit: cm, positive: down", "column: fixed", "heave never changes: another column"),
    ],
)
def test_what_cannot_be_in_the_unit_of_the_map_is_refused_with_the_likely_cause(own, tmp_path, right, wrong, words):
    whole, nominal = own
    names, *rows = write_log(whole, nominal, tmp_path / "log.csv").read_text().splitlines()
    (tmp_path / "log.csv").write_text(
        "\n".join([f"{names},fixed", *(f"{row},2.5" for row in rows)]) + "\n", encoding="utf-8"
    )
    assert LOG.count(right) == 1
    with pytest.raises(CommandError, match=words):
        read_others(tmp_path / "log.csv", map_of(tmp_path, LOG.replace(right, wrong)), nominal, TICK)


@pytest.mark.parametrize(
    ("column", "text", "sensor", "note"),
    [
        ("load", "NaN", "", "tension: no number came from 4.0 s to 7.0 s: the load cell is not used"),
        ("load", "-9999", "", "tension: 59 samples of -9999, the first at"),
        ("rope", "-9999", "encoder", "payout: 59 samples of -9999, the first at"),
        ("pressure", "99.999", "depth", "pressure: 29 samples of 99.999, the first at"),
        ("heave", "9999", "mru", "heave: 59 samples of 9999, the first at"),
    ],
)
def test_what_stands_for_no_number_is_none_and_said(own, tmp_path, column, text, sensor, note):
    whole, nominal = own
    names, *rows = write_log(whole, nominal, tmp_path / "log.csv").read_text().splitlines()
    place, cells = names.split(",").index(column), [row.split(",") for row in rows]
    for row in cells:
        if 4.0 < float(row[0]) - HOST < 7.0 and row[place]:
            row[place] = text
    (tmp_path / "log.csv").write_text("\n".join([names, *map(",".join, cells)]) + "\n", encoding="utf-8")
    found, notes = read_others(tmp_path / "log.csv", map_of(tmp_path, LOG), nominal, TICK)
    assert any(one.startswith(note) for one in notes), notes
    assert [one.sensor for one in found.losses if one.end - one.start > 1.0] == ([sensor] if sensor else [])
    assert np.isnan(found.tension).all() == (column == "load")


@pytest.mark.parametrize("share", [0.0, 0.9])
def test_the_mean_payout_of_a_drum_is_what_no_wave_moves(share):
    time = TICK * np.arange(1, 6001)
    heave = 0.5 * np.sin(0.6 * time + 1.0) + 0.3 * np.sin(0.45 * time) + 0.2 * np.sin(0.8 * time)
    slow = 2.0 * np.sin(2.0 * math.pi * time / 900.0)
    # the running mean itself leaves 1.5 % of so slow a motion, and more at the ends
    middle = slice(1500, -1500)
    assert mean_payout(time, slow + share * heave, heave)[middle] == pytest.approx(slow[middle], abs=0.035)
    # a drum at rest in the mean: to the ends
    assert mean_payout(time, 1.0 + share * heave, heave) == pytest.approx(np.ones_like(time), abs=1e-9)


@pytest.mark.parametrize(
    ("left_out", "words"),
    [
        ("heave:", "the map names no heave: the boom tip's motion is not known"),
        ("payout:", "the map names no payout: what the drum did is not known"),
        ("pressure:", "the map names no pressure or unit_heave: the unit's motion is not measured"),
    ],
)
def test_a_map_without_what_every_answer_needs_is_refused_in_one_line(own, tmp_path, left_out, words):
    whole, nominal = own
    source = write_log(whole, nominal, tmp_path / "log.csv")
    text = "\n".join(line for line in LOG.splitlines() if not line.startswith(left_out))
    with pytest.raises(CommandError, match=words):
        read_others(source, map_of(tmp_path, text), nominal, TICK)


def test_a_record_of_others_needs_a_scenario(own, tmp_path):
    source = write_log(*own, tmp_path / "log.csv")
    status, said, complaint = heave(["whatif", str(source), "--map", str(map_of(tmp_path, LOG))])
    assert status == 2
    assert "say with --scenario what cable, unit, winch and controller are" in complaint
    assert judge(status, said, complaint) == ""


@pytest.mark.long
def test_the_answer_to_a_log_is_that_to_the_bag_itself(tmp_path, monkeypatch):
    monkeypatch.setattr(campaign, "DURATION", 140.0)
    scenario = scenario_of(replace(make_draw(0, 1), settings=()), "lqg")
    _, record = Recording(scenario).record()
    nominal = scenario.parameters["winch_controller"]
    asked = [Asked("mpc", replace(nominal, law="mpc"))]
    log = write_log(record, nominal, tmp_path / "log.csv", orders=True)
    found = []
    for text in ("", LOG, f"{LOG}ordered_rate: {{column: order}}\n"):
        read = read_others(log, map_of(tmp_path, text), nominal, TICK)[0] if text else record
        known = learn(read, nominal, start=60.0)
        (answer,) = answers(known, asked)
        found.append((answer.figures.values["unit_efficiency"], off_sigma(known)))
        says = {of: is_reported for of, is_reported, _ in reported(known)}
        assert says["winch"] == read.has_orders
        assert any("no orders to the winch" in line for line in warnings(known, [answer])) != read.has_orders
        assert np.isnan(same_again(known)[1]) == bool(text)
    for efficiency, off in found[1:]:
        # within a point: rounded, and given at other times than the controller had them
        assert efficiency == pytest.approx(found[0][0], abs=0.01)
        # a compensated record shows it to some percent
        assert off == pytest.approx(found[0][1], rel=0.05)
