"""Who can reach a node is decided by a few variables: what comes of each of the user's settings."""

import os
import subprocess
import sys
from importlib import resources
from xml.etree import ElementTree

import pytest
from heave_node.ros.transport.environment import (
    PROFILE_VARIABLE,
    is_bound_to_loopback,
    is_open_to_network,
    open_to_network,
    prepare_environment,
)

RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
PROFILE = "FASTDDS_DEFAULT_PROFILES_FILE"
PROFILES = resources.files("heave_node") / "fastdds_profiles"
OF_THIS_MACHINE = dict(os.environ)

NODE = """
import os
from pathlib import Path
from heave_node.ros.transport.environment import open_to_network, prepare_environment
if {is_open}:
    open_to_network()
prepare_environment()
import rclpy
rclpy.init()
node = rclpy.create_node("short_lived")
opened = [os.path.realpath(entry) for entry in Path("/proc/self/fd").iterdir()]
mapped = Path("/proc/self/maps").read_text().splitlines()
print([line for line in (*opened, *mapped) if "/dev/shm/" in line and "fastdds" in line])
"""


@pytest.fixture(autouse=True)
def environment(monkeypatch, tmp_path):
    """An environment in which the user has set nothing, with Fast DDS 3 installed."""
    (tmp_path / "share" / "fastdds").mkdir(parents=True)
    given = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("ROS_", "RMW_", "FASTDDS_", "FASTRTPS_"))
    }
    monkeypatch.setattr(os, "environ", {**given, "AMENT_PREFIX_PATH": str(tmp_path)})
    return os.environ


@pytest.mark.parametrize("asked", [None, "LOCALHOST", "OFF", "localhost", "nonsense"])
def test_without_being_asked_a_node_is_on_loopback(environment, asked):
    if asked:
        environment[RANGE] = asked
    assert prepare_environment() == ""
    assert environment[PROFILE] == str(PROFILES / "heave_loopback_3.xml")
    assert environment[RANGE] == "SYSTEM_DEFAULT", "ROS's own ranges would add a transport on every interface"
    assert is_bound_to_loopback()


def test_the_network_is_opened_by_the_command_and_said(environment):
    environment["ROS_LOCALHOST_ONLY"] = "1"
    environment["ROS_DOMAIN_ID"] = "7"
    open_to_network()
    assert "any host of the subnet can join ROS domain 7" in prepare_environment()
    assert environment[PROFILE] == str(PROFILES / "heave_network_3.xml")
    assert environment[RANGE] == "SUBNET"
    assert not is_bound_to_loopback()


@pytest.mark.parametrize("asked", ["SUBNET", "SYSTEM_DEFAULT"])
def test_the_network_is_opened_by_ros_own_variable_and_said(environment, asked):
    environment[RANGE] = asked
    assert "open to the network" in prepare_environment()
    assert environment[PROFILE] == str(PROFILES / "heave_network_3.xml")
    assert environment[RANGE] == asked


@pytest.mark.parametrize("is_open", [False, True])
def test_what_a_command_has_set_holds_for_the_processes_that_it_starts(environment, is_open):
    if is_open:
        open_to_network()
    notice = prepare_environment()
    before = dict(environment)
    assert prepare_environment() == notice
    assert environment == before
    assert is_open_to_network() is is_open


def test_a_command_on_loopback_can_be_opened_and_closed_again(environment):
    prepare_environment()
    open_to_network()
    assert "open to the network" in prepare_environment()
    environment[RANGE] = "LOCALHOST"
    assert prepare_environment() == ""
    assert is_bound_to_loopback()


def test_ros_localhost_only_goes_before_the_range(environment):
    environment.update({"ROS_LOCALHOST_ONLY": "1", RANGE: "SUBNET"})
    assert prepare_environment() == ""
    assert "ROS_LOCALHOST_ONLY" not in environment, "it would add a transport on every interface"
    assert is_bound_to_loopback()


def test_static_peers_are_not_used_on_loopback_and_the_user_hears_it(environment):
    environment["ROS_STATIC_PEERS"] = "192.0.2.1"
    assert "ROS_STATIC_PEERS is ignored" in prepare_environment()
    assert is_bound_to_loopback()


@pytest.mark.parametrize(
    ("name", "value"), [(PROFILE, "/etc/our_ship.xml"), ("RMW_IMPLEMENTATION", "rmw_cyclonedds_cpp")]
)
def test_a_transport_of_the_users_own_is_left_alone_and_said(environment, name, value):
    environment[name] = value
    assert f"{name}={value}" in prepare_environment()
    assert environment[name] == value
    assert environment[RANGE] == "LOCALHOST"
    assert not is_bound_to_loopback()


def test_fast_dds_2_gets_its_own_variable_and_profile(environment, tmp_path):
    old = tmp_path / "jazzy"
    (old / "share" / "fastrtps").mkdir(parents=True)
    environment["AMENT_PREFIX_PATH"] = os.pathsep.join([str(old), str(tmp_path)])
    prepare_environment()
    assert environment["FASTRTPS_DEFAULT_PROFILES_FILE"] == str(PROFILES / "heave_loopback_2.xml")
    assert PROFILE not in environment


def test_where_no_fast_dds_is_seen_the_newest_is_taken_for_granted(environment):
    del environment["AMENT_PREFIX_PATH"]
    prepare_environment()
    assert environment["AMENT_PREFIX_PATH"] == sys.prefix
    assert environment[PROFILE].endswith("_3.xml")


# The tags of the times of a writer, by major version of Fast DDS: resources/xsd/fastRTPS_profiles.xsd of 2.14.4 and
# resources/xsd/fastdds_profiles.xsd of 3.2.2.
TAGS = {
    2: ("heartbeatPeriod", "nackSupressionDuration"),
    3: ("heartbeat_period", "nack_supression_duration"),
}


@pytest.mark.parametrize("reach", ["loopback", "network"])
def test_the_profiles_differ_between_versions_of_fast_dds_in_the_names_of_tags_only(reach):
    contents = {}
    for version in PROFILE_VARIABLE:
        text = (PROFILES / f"heave_{reach}_{version}.xml").read_text(encoding="utf-8")
        root = ElementTree.fromstring(text)
        namespace = root.tag.removesuffix("profiles")
        assert [tag.tag.removeprefix(namespace) for tag in root.find(f".//{namespace}times")] == list(TAGS[version])
        for tag, common in zip(TAGS[version], TAGS[3], strict=True):
            text = text.replace(tag, common)
        contents[version] = text.replace(namespace.strip("{}"), "namespace")
    assert contents[2] == contents[3]


@pytest.mark.skipif(sys.platform != "linux", reason="what a process holds is read as Linux shows it")
@pytest.mark.parametrize("is_open", [False, True])
def test_a_node_shares_no_memory_with_those_that_join_or_die(is_open):
    """By shared memory, who joins stops a node of the loop for 333 ms (Fast DDS, issue 6535), and who is killed while
    he holds a lock stops it for ever.
    """
    environment = {**OF_THIS_MACHINE, "ROS_DOMAIN_ID": "231"}
    program = [sys.executable, "-c", NODE.format(is_open=is_open)]
    done = subprocess.run(program, env=environment, capture_output=True, text=True, timeout=120, check=True)
    assert done.stdout == "[]\n"


@pytest.mark.parametrize("reach", ["loopback", "network"])
@pytest.mark.parametrize("version", PROFILE_VARIABLE)
def test_endpoints_match_by_type_name(reach, version):
    """Types that are sent about are looked up by the others; where that fails a run waits for ever for a match."""
    root = ElementTree.fromstring((PROFILES / f"heave_{reach}_{version}.xml").read_text(encoding="utf-8"))
    namespace = root.tag.removesuffix("profiles")
    properties = {
        entry.findtext(f"{namespace}name"): entry.findtext(f"{namespace}value")
        for entry in root.iter(f"{namespace}property")
    }
    assert properties == {"fastdds.type_propagation": "disabled"}


def test_without_a_home_ros_keeps_its_logs_below_the_temporary_folder(environment, tmp_path):
    """As in a container with a read-only root: rcl would refuse to start, for it cannot make ~/.ros/log."""
    environment |= {"HOME": "/proc/nohome", "TMPDIR": str(tmp_path)}
    prepare_environment()
    assert environment["ROS_LOG_DIR"].endswith(f"heave-ros-log-{os.getuid()}")
    environment["ROS_LOG_DIR"] = "/of/the/user"
    prepare_environment()
    assert environment["ROS_LOG_DIR"] == "/of/the/user"


def test_with_a_home_the_logs_stay_where_ros_has_them(environment, tmp_path):
    environment["HOME"] = str(tmp_path)
    prepare_environment()
    assert "ROS_LOG_DIR" not in environment
