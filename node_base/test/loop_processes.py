"""The processes of `loop_program` in a ROS domain of their own, for tests."""

import os
import subprocess
import sys
from pathlib import Path

PROGRAM = Path(__file__).with_name("loop_program.py")
PEERS = ("wave_vessel", "winch_controller", "virtual_winch")
SUM_OF_40_TICKS = sum(range(1, 41))
"""The plant sums the sequence numbers of the sea, one per tick."""


class Loop:
    """Four processes in a domain of their own."""

    def __init__(self, domain: int) -> None:
        self.environment = {**os.environ, "ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
        self.processes: dict[str, subprocess.Popen[str]] = {}

    def start(self, *names: str, **parameters: object) -> None:
        given = {"duration": 2.0, "participants": f"[{', '.join(PEERS)}]", **parameters}
        arguments = [part for name, value in given.items() for part in ("-p", f"{name}:={value}")]
        for name in names:
            self.processes[name] = subprocess.Popen(
                [sys.executable, str(PROGRAM), name, "--ros-args", *arguments],
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
                env=self.environment,
            )

    def end(self, name: str, timeout: float = 40.0) -> tuple[int, str, str]:
        out, err = self.processes[name].communicate(timeout=timeout)
        return self.processes[name].returncode, out, err

    def stop(self) -> None:
        for process in self.processes.values():
            if process.poll() is None:
                process.kill()
                process.communicate()


def start_all(loop: Loop, fault_of: str = "", **parameters: object) -> None:
    """Start the four processes; the fault parameters go to one of them only."""
    faults = {name: parameters.pop(name) for name in ("fault", "fault_tick") if name in parameters}
    for name in (*PEERS, "cable_sim"):
        loop.start(name, **parameters, **(faults if name == fault_of else {}))
