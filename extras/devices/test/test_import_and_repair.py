"""Ships' records become a sea; damaged bags become sound ones."""

import math

import numpy as np
import pytest
from geometry_msgs.msg import Quaternion, Vector3
from heave_bags.errors import BagError
from heave_bags.mcap import repair
from heave_bags.mcap.bag_writer import BagPolicy, BagWriter
from heave_bags.mcap.reader import Bag
from heave_bags.mcap.writer import ChunkPolicy
from heave_devices.maps.channel import DEFAULT_CUT_OFF, Channel
from heave_devices.maps.device_map import DeviceMap
from heave_devices.records import sea_import, sea_mapping
from heave_devices.records.sea_import import boom_tip_motion, import_sea, integrated
from heave_msgs.msg import MruSample
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import serialize_message
from rosbags.highlevel import AnyReader
from sensor_msgs.msg import Imu
from std_msgs.msg import Float64

from bags.test.made_up_run import MadeUpRun, header

OMEGA = 2.0 * math.pi / 8.0
PERIOD_NS = 50_000_000


def ship_bag(folder, duration=240.0):
    """Write a ship's own bag: heave as Float64, an Imu with the acceleration of a heave of 1 m and a roll of 0.1
    rad.
    """
    writer = BagWriter(folder)
    writer.add_topic("/mru/heave", "std_msgs/msg/Float64")
    writer.add_topic("/imu/data", "sensor_msgs/msg/Imu")
    for number in range(1, round(duration / 0.05) + 1):
        stamp = number * PERIOD_NS
        sine = math.sin(OMEGA * stamp * 1e-9)
        half_roll = 0.05 * sine
        imu = Imu(
            header=header(stamp),
            linear_acceleration=Vector3(z=9.80665 - OMEGA**2 * sine),
            orientation=Quaternion(x=math.sin(half_roll), w=math.cos(half_roll)),
        )
        writer.write("/mru/heave", stamp, bytes(serialize_message(Float64(data=sine))))
        writer.write("/imu/data", stamp, bytes(serialize_message(imu)))
    writer.close()
    return folder


@pytest.fixture(scope="module")
def ship(tmp_path_factory):
    return ship_bag(tmp_path_factory.mktemp("ship") / "bag")


def heave_of(sea):
    return sea.position[:, 2], np.sin(OMEGA * (sea.time + 0.05))


def test_a_heave_topic_is_the_sea(ship):
    got, expected = heave_of(import_sea(ship, "/mru/heave"))
    assert np.abs(got - (expected - expected.mean())).max() < 1e-9


def test_acceleration_is_integrated_to_the_heave_it_came_from(ship):
    got, expected = heave_of(import_sea(ship, "imu/data"))
    middle = slice(len(got) // 4, -len(got) // 4)
    assert np.abs(got - expected)[middle].max() < 0.01


def test_double_integration_of_a_whole_number_of_waves_is_exact():
    time = np.arange(0.0, 160.0, 0.05)
    motion = integrated(-(OMEGA**2) * np.sin(OMEGA * time) + 9.8, 0.05, DEFAULT_CUT_OFF)
    assert np.abs(motion - np.sin(OMEGA * time)).max() < 1e-9


def test_a_mapping_file_joins_topics_and_moves_the_point(ship, tmp_path):
    path = tmp_path / "ship.yaml"
    path.write_text(
        "heave: {topic: /mru/heave}\nroll: {topic: /imu/data, field: orientation, part: roll}\nlever_arm: [0, 10, 0]\n"
    )
    sea = import_sea(ship, sea_mapping.read_mapping(path))
    sine = np.sin(OMEGA * (sea.time + 0.05))
    expected = sine + 10.0 * np.sin(0.1 * sine)
    assert np.abs(sea.position[:, 2] - (expected - expected.mean())).max() < 1e-6


def test_samples_that_the_unit_itself_calls_invalid_are_gaps(tmp_path):
    writer = BagWriter(tmp_path / "bag")
    writer.add_topic("/mru", "heave_msgs/msg/MruSample")
    for number in range(1, 2401):
        is_bad = 1000 <= number < 1020
        sample = MruSample(header=header(number * PERIOD_NS), status=2 if is_bad else number < 10)
        sample.heave = 99.0 if is_bad else math.sin(OMEGA * 0.05 * number)
        writer.write("/mru", number * PERIOD_NS, bytes(serialize_message(sample)))
    writer.close()
    sea = import_sea(tmp_path / "bag", "/mru")
    got, expected = heave_of(sea)
    assert "heave: 20 samples that status calls invalid left out" in sea.notes
    # one second of a sine of 8 s, bridged by a cubic: (pi/4)^4/384 of its amplitude
    assert np.abs(got - (expected - expected.mean())).max() < 2e-3
    with pytest.raises(BagError, match="has no field flags that is a number or a flag"):
        import_sea(tmp_path / "bag", DeviceMap({"heave": Channel(topic="/mru", field="heave", valid="flags")}))


def test_a_csv_log_is_the_sea_and_bad_cells_are_told(tmp_path):
    log = tmp_path / "log.csv"
    rows = [f"{1000 * (5.0 + 0.1 * n):.1f},{100 * math.sin(OMEGA * 0.1 * n):.6f}" for n in range(600)]
    rows[100] = rows[100].split(",")[0] + ",n/a"
    log.write_text("# ship log\nms,heave_cm\n" + "\n".join(rows) + "\n")
    mapping = DeviceMap({"heave": Channel(column="heave_cm", scale=0.01)}, time_column="ms", time_scale=1e-3)
    sea = import_sea(log, mapping)
    assert sea.notes == ["heave: 1 sample without a number, or not later than the one before, skipped"]
    expected = np.sin(OMEGA * sea.time)
    assert np.abs(sea.position[:, 2] - (expected - expected.mean())).max() < 1e-3


def test_the_result_is_read_by_the_node_that_plays_it(ship, tmp_path):
    recording = pytest.importorskip("wave_vessel_node.sources.recording")
    sea = import_sea(ship, "/mru/heave")
    sea_import.write_sea(sea, tmp_path / "sea.csv", ship)
    read = recording.read_recording(tmp_path / "sea.csv")
    assert np.abs(read.position - sea.position).max() < 1e-5


def test_missing_fields_are_refused(ship, tmp_path):
    log = tmp_path / "log.csv"
    log.write_text("time_s,heave\n" + "\n".join(f"{n},0" for n in range(100)))
    with pytest.raises(BagError, match="no field linear"):
        import_sea(ship, DeviceMap({"heave": Channel(topic="/imu/data", field="linear")}))
    with pytest.raises(BagError, match="no column 'h'"):
        import_sea(log, DeviceMap({"heave": Channel(column="h")}))


@given(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.tuples(*[st.floats(-50, 50)] * 3))
def test_the_boom_tip_keeps_its_distance_from_the_sensor(roll, pitch, arm):
    motions = {"heave": np.zeros(1), "roll": np.array([roll]), "pitch": np.array([pitch])}
    assert np.linalg.norm(boom_tip_motion(motions, arm, 1)) == pytest.approx(np.linalg.norm(arm), abs=1e-9)


def test_bow_down_lowers_what_is_ahead_and_starboard_down_lifts_what_is_to_port():
    motions = {"heave": np.zeros(1), "pitch": np.array([0.1])}
    assert boom_tip_motion(motions, (10.0, 0.0, 0.0), 1)[0, 2] < 0.0
    motions = {"heave": np.zeros(1), "roll": np.array([0.1])}
    assert boom_tip_motion(motions, (0.0, 10.0, 0.0), 1)[0, 2] > 0.0


def test_a_cut_bag_is_repaired_to_one_that_others_open_and_the_loss_is_stated(made_up_bag, tmp_path):
    folder = made_up_bag(run=MadeUpRun(duration=20.0), policy=BagPolicy(ChunkPolicy(size=8_000)))
    (path,) = folder.glob("*.mcap")
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])
    (folder / "metadata.yaml").unlink()
    repaired = repair.repair(folder, tmp_path / "repaired")
    assert "messages lost" in str(repaired)
    messages = list(Bag(folder).messages())
    assert list(Bag(repaired.folder).messages()) == messages
    assert len(messages) == repaired.messages > 0
    with AnyReader([repaired.folder]) as reader:
        assert sum(1 for _ in reader.messages()) == repaired.messages
    assert Bag(repaired.folder).run["scenario"] == "made_up"


def test_an_index_is_made_again(made_up_bag):
    folder = made_up_bag(run=MadeUpRun(duration=5.0))
    before = (folder / "metadata.yaml").read_text()
    (folder / "metadata.yaml").unlink()
    repair.reindex(folder)
    assert (folder / "metadata.yaml").read_text() == before


def test_a_damaged_bag_is_repaired_not_reindexed(made_up_bag):
    folder = made_up_bag(run=MadeUpRun(duration=5.0))
    (path,) = folder.glob("*.mcap")
    path.write_bytes(path.read_bytes()[:-500])
    with pytest.raises(BagError, match="repair the bag instead"):
        repair.reindex(folder)
