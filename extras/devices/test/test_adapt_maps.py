"""The shipped maps, each on what its device says: messages built from the published definitions of their types.

Types that are not installed are made of the fields of their published definitions by rosbags; the same messages, in a
bag, are read by the same maps as the sea of a record.
"""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from heave_devices.adapt.shipped import find_map, shipped_maps, title_of
from heave_devices.live.adapter import Adapter
from heave_devices.maps.device_map import device_map_of
from heave_devices.records.sea_import import import_sea
from heave_devices.records.sea_mapping import read_mapping
from heave_node.files.bounded_yaml import parse_yaml
from heave_node.interface.codes import MruStatus
from heave_node.interface.sensors import mru_reading
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from scipy.spatial.transform import Rotation

NUMBERS = ["float32", "float64", "uint8", "uint16", "uint32", "bool", "string"]
DEFINITIONS = {
    # sbg_driver: SbgShipMotion, SbgShipMotionStatus, SbgEkfEuler and its status, the fields that the maps read
    "sbg_driver/msg/SbgShipMotionStatus": "bool heave_valid\nbool heave_vel_aided\nbool surge_sway_included\n"
    "bool period_available\nbool period_valid\nbool swell_mode",
    "sbg_driver/msg/SbgShipMotion": "std_msgs/Header header\nuint32 time_stamp\nuint16 heave_period\n"
    "geometry_msgs/Vector3 ship_motion\ngeometry_msgs/Vector3 acceleration\ngeometry_msgs/Vector3 velocity\n"
    "SbgShipMotionStatus status",
    "sbg_driver/msg/SbgEkfStatus": "uint8 solution_mode\nbool attitude_valid\nbool heading_valid",
    "sbg_driver/msg/SbgEkfEuler": "std_msgs/Header header\nuint32 time_stamp\ngeometry_msgs/Vector3 angle\n"
    "geometry_msgs/Vector3 accuracy\nSbgEkfStatus status",
    # novatel_oem7_msgs: INSPVA
    "novatel_oem7_msgs/msg/Oem7Header": "string message_name\nuint16 message_id\nuint8 message_type\n"
    "uint32 sequence_number\nuint8 time_status\nuint16 gps_week_number\nuint32 gps_week_milliseconds",
    "novatel_oem7_msgs/msg/InertialSolutionStatus": "uint32 status",
    "novatel_oem7_msgs/msg/INSPVA": "std_msgs/Header header\nOem7Header nov_header\nfloat64 latitude\n"
    "float64 longitude\nfloat64 height\nfloat64 north_velocity\nfloat64 east_velocity\nfloat64 up_velocity\n"
    "float64 roll\nfloat64 pitch\nfloat64 azimuth\nInertialSolutionStatus status",
}
STORE = get_typestore(Stores.LATEST)
for name, text in DEFINITIONS.items():
    STORE.register(get_types_from_msg(text, name))
OMEGA, AMPLITUDE = 2.0 * math.pi / 9.0, 0.7


def made(name, time=0.0, **values):
    """Return a message of a type: fields as given by dotted name, others 0."""
    message = _blank(name)
    if hasattr(message, "header"):
        message.header.stamp = STORE.types["builtin_interfaces/msg/Time"](int(time), round(time % 1.0 * 1e9))
    for path, value in values.items():
        *way, last = path.split("__")
        holder = message
        for step in way:
            holder = getattr(holder, step)
        setattr(holder, last, value)
    return message


def _blank(name):
    plain = {"string": "", "bool": False, "float32": 0.0, "float64": 0.0}
    values = []
    for _, (kind, detail) in STORE.fielddefs[name][1]:
        if kind.name == "BASE":
            values.append(plain.get(detail[0], 0))
        elif kind.name == "NAME":
            values.append(_blank(detail))
        else:
            (inner, what), length = detail
            is_text = inner.name == "BASE" and what[0] == "string"
            values.append([""] * length if is_text else np.zeros(length))
    return STORE.types[name](*values)


def heave(t):
    return AMPLITUDE * math.sin(OMEGA * t)


def rate(t):
    return AMPLITUDE * OMEGA * math.cos(OMEGA * t)


TURN = {"orientation__x": math.sin(0.05), "orientation__w": math.cos(0.05)}
"""A roll of 0.1 rad, starboard down."""


def of_sbg(t):
    yield (
        "/sbg/ekf_euler",
        made("sbg_driver/msg/SbgEkfEuler", t, angle__x=0.1, angle__y=0.02, status__attitude_valid=True),
    )
    is_good = t % 40.0 < 39.8
    motion = {"ship_motion__z": -heave(t) if is_good else 99.0, "velocity__z": -rate(t), "status__heave_valid": is_good}
    yield "/sbg/ship_motion", made("sbg_driver/msg/SbgShipMotion", t, **motion)


def of_novatel(t):
    values = {
        "height": 41.0 + heave(t),
        "up_velocity": rate(t),
        "roll": math.degrees(0.1),
        "pitch": -math.degrees(0.02),
    }
    status = (3, 6, 7)[int(t) % 3] if t % 40.0 < 39.8 else 1  # a ship that keeps its place stays at 7
    if status == 1:
        values["height"] = -9999.0
    yield "/novatel/oem7/inspva", made("novatel_oem7_msgs/msg/INSPVA", t, **values, status__status=status)


def of_xsens(t):
    yield "/imu/data", made("sensor_msgs/msg/Imu", t, **TURN)
    yield "/filter/velocity", made("geometry_msgs/msg/Vector3Stamped", t, vector__z=rate(t))


def underway(t, height):
    """Return an odometry whose twist is in the body's axes, as nav_msgs has it: the ship makes 2 m/s, trimmed by 1
    degree, on a course of 40 degrees."""
    turn = Rotation.from_euler("ZYX", [0.7, math.radians(1.0), 0.1])
    body = turn.inv().apply([2.0 * math.cos(0.7), 2.0 * math.sin(0.7), rate(t)])
    values = {f"twist__twist__linear__{axis}": value for axis, value in zip("xyz", body, strict=True)}
    values |= {f"pose__pose__orientation__{axis}": value for axis, value in zip("xyzw", turn.as_quat(), strict=True)}
    return made("nav_msgs/msg/Odometry", t, pose__pose__position__z=height + heave(t), **values)


def of_microstrain(t):
    yield "/ekf/imu/data", made("sensor_msgs/msg/Imu", t, **TURN)
    yield "/ekf/odometry_map", underway(t, -3.0)


def of_odometry(t):
    yield "/odometry", underway(t, 5.0)


def of_imu_and_twist(t):
    yield "/imu/data", made("sensor_msgs/msg/Imu", t, **TURN)
    yield "/velocity", made("geometry_msgs/msg/TwistStamped", t, twist__linear__z=rate(t))


MESSAGES = {
    "sbg_ship_motion": of_sbg,
    "novatel_inspva": of_novatel,
    "xsens": of_xsens,
    "microstrain": of_microstrain,
    "odometry": of_odometry,
    "imu_and_twist": of_imu_and_twist,
}


@pytest.mark.parametrize("name", MESSAGES)
def test_messages_of_the_published_definition_become_readings(name):
    """A heave filter of 300 s leads by 2 * 0.7 * 9 / 300 rad: 4 % of the amplitude and more are its error at most."""
    adapter = Adapter(find_map(name))
    readings, times = [], []
    for n in range(8000):
        t = 1000.0 + 0.05 * n
        for topic, message in MESSAGES[name](t):
            made_of_it = adapter.on_message(topic, message, round(t * 1e9), 0.0)
            readings += [mru_reading(reading) for _, reading in made_of_it]
    assert not adapter.taker.counters.missing
    good = [reading for reading in readings[-1600:] if reading.status == MruStatus.OK]
    assert len(good) >= 1590
    times = [reading.time for reading in good]
    error = np.array([reading.heave for reading in good]) - [heave(t) for t in times]
    assert np.abs(error).max() < 0.06 * AMPLITUDE
    assert [reading.heave_rate for reading in good] == pytest.approx([rate(t) for t in times], abs=1e-6)
    assert good[-1].roll == pytest.approx(0.1, abs=1e-6)
    bad = [reading for reading in readings if reading.status == MruStatus.INVALID]
    assert all(math.isnan(reading.heave) for reading in bad)
    assert bool(bad) == (name in ("sbg_ship_motion", "novatel_inspva"))


def test_nothing_that_is_called_invalid_reaches_height_and_period_of_a_bag(tmp_path):
    """99 m with heave_valid: false would make a significant height of tens of metres."""
    path = tmp_path / "bag"
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connections = {}
        for n in range(6000):
            t = 1000.0 + 0.05 * n
            for topic, message in of_sbg(t):
                kind = message.__msgtype__
                if topic not in connections:
                    connections[topic] = writer.add_connection(topic, kind, typestore=STORE)
                writer.write(connections[topic], round(t * 1e9), STORE.serialize_cdr(message, kind))
    sea = import_sea(path, read_mapping(shipped_maps()["sbg_ship_motion"]))
    assert np.abs(sea.position[:, 2]).max() == pytest.approx(AMPLITUDE, rel=0.01)
    # positive up: at the first whole period the heave is that of the truth, not its mirror image
    truth = np.array([heave(sea.start + t) for t in sea.time])
    assert np.corrcoef(sea.position[:, 2], truth - truth.mean())[0, 1] > 0.999


@pytest.mark.parametrize("frame", ["NED", "ENU"])
def test_ship_motion_of_sbg_is_positive_down_in_either_frame_of_its_driver(frame):
    """sbg_driver 3.3.2, message_wrapper.cpp: use_enu turns the attitude, not the ship motion."""
    text = shipped_maps()["sbg_ship_motion"].read_text(encoding="utf-8")
    adapter = Adapter(device_map_of("m", parse_yaml(text.replace("frame: NED", f"frame: {frame}"))))
    sign = -1.0 if frame == "NED" else 1.0
    angles = made("sbg_driver/msg/SbgEkfEuler", 1.0, angle__x=0.1, angle__y=sign * 0.02, status__attitude_valid=True)
    adapter.on_message("/sbg/ekf_euler", angles, 10**9, 0.0)
    values = {"ship_motion__z": -0.3, "velocity__z": -0.2, "acceleration__z": -0.1, "status__heave_valid": True}
    message = made("sbg_driver/msg/SbgShipMotion", 1.0, **values)
    ((_, reading),) = adapter.on_message("/sbg/ship_motion", message, 10**9, 0.0)
    mru = mru_reading(reading)
    assert (mru.heave, mru.heave_rate, mru.heave_acceleration) == pytest.approx((0.3, 0.2, 0.1))
    assert (mru.roll, mru.pitch) == pytest.approx((0.1, 0.02))
    entry = {"topic": "/sbg/ship_motion", "type": "sbg_driver/msg/SbgShipMotion", "field": "ship_motion.z"}
    own = Adapter(device_map_of("m", {"heave": {**entry, "positive": "up"}, "frame": frame}))
    ((_, reading),) = own.on_message("/sbg/ship_motion", message, 10**9, 0.0)
    assert mru_reading(reading).heave == pytest.approx(-0.3), "what the map says itself goes before the type"


def test_a_vertical_velocity_of_an_odometry_in_a_bag_is_turned_into_the_world(tmp_path):
    """Heave from the twist of a ship under way, its map without a type, as of a record."""
    path = tmp_path / "bag"
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        kind = "nav_msgs/msg/Odometry"
        connection = writer.add_connection("/odometry", kind, typestore=STORE)
        for n in range(6000):
            t = 1000.0 + 0.05 * n
            writer.write(connection, round(t * 1e9), STORE.serialize_cdr(underway(t, 5.0), kind))
    mapping = tmp_path / "map.yaml"
    mapping.write_text("heave: {topic: /odometry, field: twist.twist.linear.z, velocity: true}\n")
    sea = import_sea(path, read_mapping(mapping))
    truth = np.array([heave(sea.start + t) for t in sea.time])
    inside = slice(800, -800)
    assert np.abs(sea.position[inside, 2] - (truth - truth.mean())[inside]).max() < 0.05 * AMPLITUDE


def test_joint_states_become_the_pose_of_a_crane():
    adapter = Adapter(find_map("crane_joint_states"))
    joints = {"telescope": 2.5, "knuckle": -0.4, "slew": 1.2, "luff": 0.7}
    state = SimpleNamespace(name=list(joints), position=list(joints.values()), velocity=[])
    ((topic, pose),) = adapter.on_message("/crane/joint_states", state, 10**9, 0.0)
    assert (topic, pose.stamp, pose.numbers[:4]) == ("crane/pose", 10**9, (1.2, 0.7, -0.4, 2.5))
    assert all(map(math.isnan, pose.numbers[4:])), "no rate is measured"
    state.name.remove("luff")
    ((_, later),) = adapter.on_message("/crane/joint_states", state, 3 * 10**9, 2.0)
    assert math.isnan(later.numbers[1]), "one that is older than the timeout is not known"


def test_pencr_becomes_the_pose_of_a_crane_by_the_signs_of_the_map():
    """SMC IMU-108 User Guide rev. 3.1, 4.10.7: 3FFF, 2000, 0FA0 are 90, 45 and 22 degrees of base, first and second
    knuckle, 03E8 is 10 m; it gives no sign, so that of the base is the map's: clockwise."""
    device = find_map("pencr")
    adapter = Adapter(device)
    samples = device.decoder().feed(b"$PENCR,3FFF,2000,0FA0,03E8,0000\r\n")
    ((topic, pose),) = adapter.on_samples(samples, 5.0)
    assert (topic, pose.stamp) == ("crane/pose", 0), "the time of arrival counts"
    assert np.degrees(pose.numbers[:3]) == pytest.approx([-90.0, 45.0, 22.0], abs=0.1)
    assert pose.numbers[3] == 10.0


def test_each_shipped_map_says_what_it_is_for_and_can_be_read():
    names = shipped_maps()
    assert len(names) >= 15
    assert all(len(title_of(path)) > 20 for path in names.values())
    assert all(find_map(name).outputs for name in names)
