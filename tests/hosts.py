"""Hosts for tests: network namespaces joined by a cable, each with shared memory of its own, so that what one host can
do to another is tried for real and nothing leaves this machine.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

WHAT_DECIDES_ON_THE_TRANSPORT = (
    "ROS_AUTOMATIC_DISCOVERY_RANGE",
    "ROS_STATIC_PEERS",
    "ROS_LOCALHOST_ONLY",
    "ROS_DOMAIN_ID",
    "FASTDDS_DEFAULT_PROFILES_FILE",
    "FASTRTPS_DEFAULT_PROFILES_FILE",
)


class Host:
    """A network namespace with an address on the cable, and a folder that stands for its /dev/shm."""

    def __init__(self, name: str, address: str) -> None:
        self.name = name
        self.address = address
        self.shared_memory = Path("/dev/shm") / name

    def command(self, *command: str) -> list[str]:
        """Return a command line that runs a command on this host."""
        script = f'mount --bind {self.shared_memory} /dev/shm && exec "$@"'
        return ["ip", "netns", "exec", self.name, "unshare", "--mount", "sh", "-c", script, "sh", *command]

    def start(self, *command: str, environment: Mapping[str, str] | None = None) -> subprocess.Popen[str]:
        """Start a command on this host, in this test's environment less what it says about the transport."""
        own = {name: value for name, value in os.environ.items() if name not in WHAT_DECIDES_ON_THE_TRANSPORT}
        return subprocess.Popen(
            self.command(*command),
            env={**own, **(environment or {})},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    def plug(self, state: str) -> None:
        """Set this host's end of the cable `up` or `down`."""
        _ip("-n", self.name, "link", "set", "cable", state)

    def send_slowly(self, rate: str, burst: str = "16kb") -> None:
        """Let this host send no faster than a `rate`, and no more than a `burst` at once, as tc writes them.

        What would wait for longer than 0.4 s is dropped, and every packet that is larger than the burst.
        """
        self._shape("replace", "tbf", "rate", rate, "burst", burst, "latency", "400ms")

    def send_freely(self) -> None:
        """Undo `send_slowly`."""
        self._shape("delete")

    def _shape(self, verb: str, *shape: str) -> None:
        command = ["ip", "netns", "exec", self.name, "tc", "qdisc", verb, "dev", "cable", "root", *shape]
        subprocess.run(command, check=True)


def why_not() -> str:
    """Say why this machine can make no hosts; "" where it can."""
    if os.geteuid() != 0:
        return "network namespaces need root"
    if shutil.which("ip") is None or shutil.which("unshare") is None:
        return "network namespaces need ip (iproute2) and unshare (util-linux)"
    probe = f"heave-{os.getpid()}"
    made = subprocess.run(["ip", "netns", "add", probe], capture_output=True, text=True, check=False)
    if made.returncode:
        return f"no network namespace can be made here: {made.stderr.strip()}"
    _ip("netns", "delete", probe)
    return ""


@contextmanager
def two_hosts() -> Iterator[tuple[Host, Host]]:
    """Make two hosts that a cable joins."""
    hosts = tuple(Host(f"heave-{os.getpid()}-{n}", f"10.77.0.{n}") for n in (1, 2))
    try:
        for host in hosts:
            host.shared_memory.mkdir()
            _ip("netns", "add", host.name)
        ends = (["cable", "netns", host.name] for host in hosts)
        _ip("link", "add", *next(ends), "type", "veth", "peer", "name", *next(ends))
        for host in hosts:
            _ip("-n", host.name, "address", "add", f"{host.address}/24", "dev", "cable")
            for device in ("lo", "cable"):
                _ip("-n", host.name, "link", "set", device, "up")
            _ip("-n", host.name, "route", "add", "224.0.0.0/4", "dev", "cable")
            # The kernel answers one closed port a second by default: a test asks hundreds.
            _ip("netns", "exec", host.name, "sh", "-c", "echo 0 > /proc/sys/net/ipv4/icmp_ratelimit")
        yield hosts[0], hosts[1]
    finally:
        for host in hosts:
            subprocess.run(["ip", "netns", "delete", host.name], capture_output=True, check=False)
            shutil.rmtree(host.shared_memory, ignore_errors=True)


def _ip(*arguments: str) -> None:
    subprocess.run(["ip", *arguments], check=True)


def drop_link(hosts: Sequence[Host], seconds: float) -> None:
    """Let no packet through between `hosts` for some wall time; the ends of the cable do not notice.

    A cable that is pulled takes longer: Linux looks at the state of a link once a second.
    """
    for host in hosts:
        host.send_slowly("8bit", burst="1b")
    time.sleep(seconds)
    for host in hosts:
        host.send_freely()


def stop(*processes: subprocess.Popen[str]) -> None:
    """Kill what still runs."""
    for process in processes:
        if process.poll() is None:
            process.kill()
        process.communicate()
