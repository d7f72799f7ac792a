import math

import numpy as np
import pytest
import zstandard
from heave_msgs.msg import MruSample, PointMotion
from mcap.writer import Writer
from rclpy.serialization import serialize_message
from wave_vessel_node.component import WaveVessel
from wave_vessel_node.parameters import WaveVesselParameters
from wave_vessel_node.sources.recording import RecordedSource, RecordingError, read_recording

DT = 0.05
TIME = np.arange(0.0, 120.0, 0.1)


def write_csv(path, rows, header="time_s,z_m"):
    lines = ["# a recording", header, *(",".join(f"{value:.9g}" for value in row) for row in rows)]
    path.write_text("\n".join(lines) + "\n")
    return path


def sine_csv(tmp_path, omega=0.7, header="time_s,z_m"):
    return write_csv(tmp_path / "motion.csv", zip(TIME + 100.0, 3.0 + np.sin(omega * TIME), strict=True), header)


def test_a_motion_in_csv_is_replayed_about_its_mean_with_rates_that_fit(tmp_path):
    recording = read_recording(sine_csv(tmp_path))
    mean = np.sin(0.7 * TIME).mean()
    source = RecordedSource(recording, DT)
    for tick in (100, 999, 2000):
        motion, t = source.motions(range(tick, tick + 1)).six[0, :, 2], tick * DT
        # cubic spline of 0.1 s: error h^4/384 of the fourth derivative in value, h^2/12 of it in acceleration
        assert motion[0] == pytest.approx(math.sin(0.7 * t) - mean, abs=1e-6)
        assert motion[1] == pytest.approx(0.7 * math.cos(0.7 * t), abs=1e-5)
        assert motion[2] == pytest.approx(-(0.7**2) * math.sin(0.7 * t), abs=1e-3)


def test_a_run_beyond_the_end_of_the_recording_says_so(tmp_path):
    source = RecordedSource(read_recording(sine_csv(tmp_path)), DT)
    with pytest.raises(RecordingError, match=r"ends after 119.9 s: give a shorter duration"):
        source.motions(range(2399, 2410))
        source.motions(range(2400, 2410))


def test_the_component_replays_a_recording(tmp_path):
    path = sine_csv(tmp_path)
    parameters = WaveVesselParameters(boom_tip_source="file", recording_file=str(path), ramp=1.0)
    vessel = WaveVessel(parameters, seed=1, tick_period=DT)
    tips = [vessel.step(tick).boom_tip for tick in range(1, 200)]
    mean = np.sin(0.7 * TIME).mean()
    assert tips[-1].position[2] == pytest.approx(math.sin(0.7 * 200 * DT) - mean, abs=1e-6)
    assert vessel.sea_state().spectrum == "file"


def test_samples_that_are_not_numbers_or_out_of_order_are_left_out_by_name(tmp_path):
    rows = [[t, math.sin(t)] for t in TIME[:200]]
    rows[50][1] = math.nan
    rows[80][0] = rows[79][0]
    recording = read_recording(write_csv(tmp_path / "m.csv", rows))
    assert len(recording.time) == 198
    assert [warning.split(": ")[1] for warning in recording.warnings] == [
        "1 non-numeric or invalid samples skipped",
        "1 samples not later than their predecessor skipped",
    ]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "is empty"),
        ("a,b\n1,2\n", "expected columns time_s and z_m"),
        ("time_s,z_m\n0,1\n1,2\n", "has 2 usable samples"),
        ("time_s,z_m\n0,1\n1\n", "line 3: 1 values where the header has 2"),
        ("time_s,z_m\n0,up\n", "line 2"),
        ("time_s,z_m\n" + "".join(f"{t},0\n" for t in (*range(8), 20, 21, 22)), "no sample for 13.0 s after 7 s"),
    ],
)
def test_a_recording_that_cannot_be_used_is_refused_in_one_line(tmp_path, text, says):
    path = tmp_path / "bad.csv"
    path.write_text(text)
    with pytest.raises(RecordingError, match=says) as error:
        read_recording(path)
    assert "\n" not in str(error.value)


def write_bag(path, name, messages, topic):
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start("ros2", "test")
        schema = writer.register_schema(name, "ros2msg", b"")
        channel = writer.register_channel(topic, "cdr", schema)
        for message in messages:
            stamp = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
            writer.add_message(channel, stamp, bytes(serialize_message(message)), stamp)
        writer.finish()
    return path


def stamped(kind, t, frame="world", **fields):
    message = kind(**fields)
    message.header.frame_id = frame
    message.header.stamp.sec, message.header.stamp.nanosec = int(t), round((t % 1.0) * 1e9)
    return message


@pytest.mark.parametrize("frame", ["", "world", "a_frame"])
def test_a_bag_of_boom_tip_motion_is_read_whatever_its_frame_is_called(tmp_path, frame):
    messages = []
    for t in TIME[1:100]:
        message = stamped(PointMotion, t, frame)
        message.position.x, message.position.y, message.position.z = float(t), 2.0, math.sin(t)
        messages.append(message)
    write_bag(tmp_path / "a.mcap", "heave_msgs/msg/PointMotion", messages, "/ship/boom_tip")
    for path in (tmp_path, tmp_path / "a.mcap"):
        recording = read_recording(path)
        np.testing.assert_allclose(recording.time, TIME[1:100] - TIME[1], atol=1e-9)
        expected = np.sin(TIME[1:100])
        np.testing.assert_allclose(recording.position[:, 2], expected - expected.mean(), atol=1e-12)
        assert recording.position[-1, 0] - recording.position[0, 0] == pytest.approx(TIME[99] - TIME[1])


def test_a_bag_of_mru_samples_is_read(tmp_path):
    messages = [stamped(MruSample, t, sequence=i, status=1, heave=math.cos(t)) for i, t in enumerate(TIME[1:100])]
    path = write_bag(tmp_path / "m.mcap", "heave_msgs/msg/MruSample", messages, "/mru")
    recording = read_recording(path)
    expected = np.cos(TIME[1:100])
    np.testing.assert_allclose(recording.position[:, 2], expected - expected.mean(), atol=1e-12)


def test_a_bag_without_the_topic_or_cut_short_is_refused(tmp_path):
    path = write_bag(tmp_path / "m.mcap", "heave_msgs/msg/MruSample", [stamped(MruSample, 1.0)], "/gyro")
    with pytest.raises(RecordingError, match="no topic boom_tip or mru; found /gyro"):
        read_recording(path)
    path.write_bytes(path.read_bytes()[:60])
    with pytest.raises(RecordingError, match="not a complete MCAP file"):
        read_recording(path)
    (tmp_path / "empty").mkdir()
    with pytest.raises(RecordingError, match=r"has no \.mcap file"):
        read_recording(tmp_path / "empty")


def test_samples_that_the_mru_calls_invalid_are_left_out(tmp_path):
    messages = [
        stamped(MruSample, t, status=2 * (10 <= i < 15), heave=99.0 if 10 <= i < 15 else math.cos(t))
        for i, t in enumerate(TIME[1:100])
    ]
    recording = read_recording(write_bag(tmp_path / "m.mcap", "heave_msgs/msg/MruSample", messages, "/mru"))
    assert np.abs(recording.position).max() < 2.0
    assert "5 non-numeric or invalid samples skipped" in recording.warnings[0]


def test_split_files_are_joined_by_their_stamps_not_by_their_names(tmp_path):
    folder = tmp_path / "bag"
    folder.mkdir()
    messages = [stamped(MruSample, t, heave=math.cos(t)) for t in TIME[1:100]]
    whole = read_recording(write_bag(tmp_path / "m.mcap", "heave_msgs/msg/MruSample", messages, "/mru"))
    for name, part in (("bag_50", messages[:33]), ("bag_30", messages[33:66]), ("bag_10", messages[66:])):
        write_bag(folder / f"{name}.mcap", "heave_msgs/msg/MruSample", part, "/mru")
    (folder / "._bag_50.mcap").write_bytes(b"left by another system")
    split = read_recording(folder)
    np.testing.assert_array_equal(split.time, whole.time)
    np.testing.assert_array_equal(split.position, whole.position)
    assert split.warnings == ()


@pytest.mark.parametrize(
    ("factor", "says"), [(100.0, "centimetres or millimetres"), (10.0, "four standard deviations of heave is 28")]
)
def test_a_motion_that_cannot_be_is_refused_unless_it_is_accepted(tmp_path, factor, says):
    # four standard deviations of a sine of 10 m are 28.3 m
    time = np.arange(0.0, 20.0 * math.pi, 0.1)
    path = write_csv(tmp_path / "m.csv", [[t, factor * math.sin(t)] for t in time])
    with pytest.raises(RecordingError, match=says) as refused:
        read_recording(path)
    assert "--set system.accept_implausible=true takes" in str(refused.value)
    assert "plausible is" in read_recording(path, accept_implausible=True).warnings[0]


def test_a_sensor_that_stood_still_is_said(tmp_path):
    rows = [[t, 0.3 if 5.0 <= t < 20.0 else math.sin(t)] for t in np.arange(0.0, 40.0, 0.1)]
    (warning,) = read_recording(write_csv(tmp_path / "m.csv", rows)).warnings
    assert "stands still for 14.9 s from 5 s on" in warning


def mru_bag(folder, names=("bag_0", "bag_1", "bag_2")):
    """Write a heave of cos t in three files; return the samples of the first two."""
    folder.mkdir()
    messages = [stamped(MruSample, t, heave=math.cos(t)) for t in TIME[:99]]
    for name, at in zip(names, (0, 33, 66), strict=True):
        write_bag(folder / f"{name}.mcap", "heave_msgs/msg/MruSample", messages[at : at + 33], "/mru")
    listed = "".join(f"  - {name}.mcap\n" for name in names)
    (folder / "metadata.yaml").write_text(f"rosbag2_bagfile_information:\n  relative_file_paths:\n{listed}")
    return np.cos(TIME[:66])


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "bag_2.mcap: the file is empty"),
        (bytes(4096), "bag_2.mcap: is not a complete MCAP file"),
        (None, "bag_2.mcap: the file is missing, which the bag lists"),
    ],
)
def test_a_bad_file_costs_a_bag_nothing_but_itself(tmp_path, content, says):
    expected = mru_bag(tmp_path / "bag")
    if content is None:
        (tmp_path / "bag" / "bag_2.mcap").unlink()
    else:
        (tmp_path / "bag" / "bag_2.mcap").write_bytes(content)
    recording = read_recording(tmp_path / "bag")
    np.testing.assert_allclose(recording.position[:, 2], expected - expected.mean(), atol=1e-12)
    (warning,) = recording.warnings
    assert says in warning


def test_a_file_without_its_end_is_read_as_far_as_it_goes(tmp_path):
    mru_bag(tmp_path / "bag")
    last = tmp_path / "bag" / "bag_2.mcap"
    opened = last.open("wb")
    writer = Writer(opened, chunk_size=1)  # a chunk for each message
    writer.start("ros2", "test")
    channel = writer.register_channel("/mru", "cdr", writer.register_schema("heave_msgs/msg/MruSample", "ros2msg", b""))
    for t in TIME[66:99]:
        writer.add_message(channel, 1, bytes(serialize_message(stamped(MruSample, t, heave=math.cos(t)))), 1)
    opened.close()  # never finished, as after a power cut
    recording = read_recording(tmp_path / "bag")
    assert len(recording.time) == 99
    (warning,) = recording.warnings
    assert "bag_2.mcap: is not a complete MCAP file" in warning
    assert "33 samples were read up to there; heave repair may recover more" in warning


def test_a_gap_names_the_file_that_is_missing(tmp_path):
    mru_bag(tmp_path / "bag")
    (tmp_path / "bag" / "bag_1.mcap").unlink()
    with pytest.raises(RecordingError, match=r"no sample for 3\.4 s after 3\.2 s.*bag_1\.mcap: the file is missing"):
        read_recording(tmp_path / "bag")


def test_a_compressed_bag_is_refused_with_the_command_that_unpacks_it(tmp_path):
    messages = [stamped(MruSample, t, heave=math.cos(t)) for t in TIME[:99]]
    path = tmp_path / "m.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start("ros2", "test")
        schema = writer.register_schema("heave_msgs/msg/MruSample", "ros2msg", b"")
        channel = writer.register_channel("/mru", "cdr", schema)
        for message in messages:
            writer.add_message(channel, 1, zstandard.compress(bytes(serialize_message(message))), 1)
        writer.finish()
    with pytest.raises(RecordingError, match=r"compressed one by one; write it anew: ros2 bag convert"):
        read_recording(path)
    path.rename(tmp_path / "m.mcap.zstd")
    with pytest.raises(RecordingError, match=r"m\.mcap\.zstd is compressed; unpack it: zstd -d"):
        read_recording(tmp_path)
