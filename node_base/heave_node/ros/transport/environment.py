"""The process environment that the middleware needs, and with it who can reach a node; one definition for nodes,
commands, tests and tools.

By default a run is on this machine alone: UDP bound to loopback. ROS's own range `LOCALHOST` is not enough for that: it
looks for nodes on this machine only, but listens on every interface, and answers whoever names this host as a static
peer. So the transport is set by a profile of Fast DDS, and the range is left to that profile.
"""

from __future__ import annotations

import contextlib
import os
import sys
import tempfile
from importlib import resources
from pathlib import Path

from heave_node.ros.transport.watchdog import check_memory

RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
STATIC_PEERS = "ROS_STATIC_PEERS"
LOCALHOST_ONLY = "ROS_LOCALHOST_ONLY"
"""Variable that stands for LOCALHOST on ROS 2 Jazzy and older, where it takes precedence over RANGE."""

PROFILE_VARIABLE = {2: "FASTRTPS_DEFAULT_PROFILES_FILE", 3: "FASTDDS_DEFAULT_PROFILES_FILE"}
"""Variable with the profiles of Fast DDS, by its major version."""
ROS_PACKAGE = {2: "fastrtps", 3: "fastdds"}
"""Fast DDS as a ROS package, by its major version."""


def prepare_environment() -> str:
    """Set what the user has not set: ament's prefix, and a transport that stays on this machine.

    Must run before `rclpy.init`; may run again. With ROS 2 from wheels the ament index lies in the Python environment.

    Returns
    -------
    One line for the user where the transport reaches beyond this machine or one of the user's settings is ignored; ""
    on loopback.

    Raises MemoryError, in one line, where a limit of this shell leaves too little address space.
    """
    check_memory()
    os.environ.setdefault("AMENT_PREFIX_PATH", sys.prefix)
    _provide_logs()
    foreign = _foreign_transport()
    if foreign:
        os.environ.setdefault(RANGE, "LOCALHOST")
        return f"the transport is configured by {foreign}: this suite does not bind it to loopback"
    is_open = is_open_to_network()
    _use_profile("network" if is_open else "loopback")
    if is_open:
        domain = os.environ.get("ROS_DOMAIN_ID", "0")
        return f"open to the network: any host of the subnet can join ROS domain {domain} and command the winch"
    # The profile says it all: ROS would add a transport of its own that listens on every interface.
    os.environ.pop(LOCALHOST_ONLY, None)
    os.environ[RANGE] = "SYSTEM_DEFAULT"
    if os.environ.get(STATIC_PEERS):
        return (
            f"{STATIC_PEERS} is ignored: this run is confined to this machine; open it with --network or {RANGE}=SUBNET"
        )
    return ""


def _provide_logs() -> None:
    """Let ROS write its logs below the temporary folder where there is no home to write them to: without, it does not
    start.
    """
    if os.environ.get("ROS_LOG_DIR") or os.environ.get("ROS_HOME"):
        return
    folder = Path("~/.ros/log").expanduser()
    with contextlib.suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
    if not os.access(folder, os.W_OK):
        os.environ["ROS_LOG_DIR"] = str(Path(tempfile.gettempdir()) / f"heave-ros-log-{os.getuid()}")


def open_to_network() -> None:
    """Let the nodes of this process, and of those that it starts, be found by other hosts of the subnet."""
    os.environ.pop(LOCALHOST_ONLY, None)
    os.environ[RANGE] = "SUBNET"


def is_open_to_network() -> bool:
    """Return whether other hosts may join: only if the user asked for it, by `--network` or ROS's variable."""
    if os.environ.get(LOCALHOST_ONLY) == "1":
        return False
    asked = os.environ.get(RANGE)
    if asked == "SYSTEM_DEFAULT":  # of the user, or set here
        return Path(os.environ.get(PROFILE_VARIABLE[_fast_dds_version()], "")).name not in _names("loopback")
    return asked == "SUBNET"


def is_bound_to_loopback() -> bool:
    """Return whether `prepare_environment` has set a transport on loopback."""
    return not _foreign_transport() and not is_open_to_network()


def _foreign_transport() -> str:
    """Return what configures the transport instead of this suite; "" where nothing does."""
    middleware = os.environ.get("RMW_IMPLEMENTATION", "")
    if middleware and "fastrtps" not in middleware:
        return f"RMW_IMPLEMENTATION={middleware}"
    variable = PROFILE_VARIABLE[_fast_dds_version()]
    profile = os.environ.get(variable, "")
    if profile and Path(profile).name not in (*_names("loopback"), *_names("network")):
        return f"{variable}={profile}"
    return ""


def _use_profile(reach: str) -> None:
    version = _fast_dds_version()
    profile = resources.files("heave_node") / "fastdds_profiles" / _name(reach, version)
    os.environ[PROFILE_VARIABLE[version]] = str(profile)
    # A file in the current folder would be read as well, and go before this one.
    os.environ["SKIP_DEFAULT_XML_FILE"] = "1"


def _name(reach: str, version: int) -> str:
    return f"heave_{reach}_{version}.xml"


def _names(reach: str) -> list[str]:
    return [_name(reach, version) for version in PROFILE_VARIABLE]


def _fast_dds_version() -> int:
    """Return the major version of the Fast DDS that ROS will load: the first one that ament's prefixes hold."""
    for prefix in os.environ.get("AMENT_PREFIX_PATH", sys.prefix).split(os.pathsep):
        for version, package in ROS_PACKAGE.items():
            if (Path(prefix) / "share" / package).is_dir():
                return version
    return max(ROS_PACKAGE)
