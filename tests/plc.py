"""A PLC of `plc_winch.py` in a process of its own, and the shipped map of its kind, set to its port."""

from __future__ import annotations

import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from heave_devices.adapt.shipped import shipped_maps

KINDS = ("modbus", "opcua", "udp")
SPOILT = ("--lost", "0.05", "--double", "0.05", "--late", "0.05", "--broken", "0.05", "--delay", "0.01")
"""One datagram in twenty lost, double, late by up to 80 ms, or with one bit changed, and each late by up to 10 ms."""


class EmulatedPlc:
    """The running program."""

    def __init__(self, kind: str, *options: str) -> None:
        self.kind = kind
        self.port, self.state_port = free_port(kind), free_port("udp")
        arguments = [kind, str(self.port), "--to", str(self.state_port), *options]
        self.process = subprocess.Popen(
            [sys.executable, str(Path(__file__).with_name("plc_winch.py")), *arguments],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        self._wait_until_ready()

    def _wait_until_ready(self) -> None:
        assert self.process.stdout is not None
        assert self.process.stdout.readline() == "ready\n"

    def begin_anew(self) -> None:
        """Let it be as it was when it was started."""
        self.tell("anew")
        self._wait_until_ready()

    def tell(self, word: str) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write(f"{word}\n")
        self.process.stdin.flush()

    def text_of_map(self) -> str:
        text = shipped_maps()[f"{self.kind}_winch"].read_text(encoding="utf-8")
        for port in ("127.0.0.1:502", "127.0.0.1:4840", "127.0.0.1:10121"):
            text = text.replace(port, f"127.0.0.1:{self.port}")
        return text.replace("udp: 10120", f"udp: {self.state_port}")

    def drum(self) -> dict[str, float]:
        """Return its greatest speed since the last time [m/s], the drum's place [m], positive in, and `enable`."""
        assert self.process.stdout is not None
        self.tell("where")
        words = self.process.stdout.readline().split()
        return dict(zip(words[::2], map(float, words[1::2]), strict=True))


def free_port(kind: str) -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM if kind == "udp" else socket.SOCK_STREAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@contextmanager
def emulated(kind: str, *options: str) -> Iterator[EmulatedPlc]:
    plc = EmulatedPlc(kind, *options)
    try:
        yield plc
    finally:
        if plc.process.poll() is None:
            plc.process.kill()
        plc.process.communicate()
