"""Node processes: started together, watched, and ended without leaving one behind."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from heave_node.ros.process import EXIT_FAILED, EXIT_OK, EXIT_REFUSED, EXIT_STUCK, in_namespace
from heave_node.ros.transport import parents_death
from heave_node.ros.transport.forked import Forked

from heave_bringup.nodes import PROCESS_BY_NAME, RECORDER
from heave_bringup.run import composed

TOGETHER = "process of all nodes"
"""Name of a process that holds them all; its log is nodes.log."""

GRACE = 3.0
"""Wall time that a node has to end after it was asked to [s]."""
GRACE_OF_FILES = 8.0
"""The same of a process that has files to close [s]."""

ALLOCATOR = {"MALLOC_TRIM_THRESHOLD_": str(1 << 30), "MALLOC_TOP_PAD_": str(1 << 24)}
"""Environment in which glibc keeps the memory that one message frees for the next.

Without it a node gives pages back to the system and asks for them again in every tick: a tenth of its time.
"""


@dataclass
class NodeProcess:
    """One process."""

    name: str  # of the node in it, or of what it holds
    process: subprocess.Popen[bytes] | Forked  # that runs it
    log: Path  # file with all that it prints
    nodes: Sequence[str]  # names of those in it

    @property
    def grace(self) -> float:
        """Wall time that it has to end after it was asked to [s]."""
        return GRACE_OF_FILES if RECORDER in self.nodes else GRACE

    @property
    def has_left(self) -> bool:
        """Whether the node has ended, and had done its work by then."""
        status = self.process.poll()
        return status == EXIT_OK or (status == EXIT_STUCK and not self._error_message())

    @property
    def has_failed(self) -> bool:
        """Whether the node has ended before its work was done."""
        return self.process.poll() is not None and not self.has_left

    def how_it_ended(self) -> str:
        """Say in one line how the node ended: in its own words where it left an error message."""
        status = self.process.returncode
        message = self._error_message()
        if message and status in (EXIT_FAILED, EXIT_REFUSED, EXIT_STUCK):
            return message
        if status is not None and status < 0:
            return f"{self.name} was killed by {signal.Signals(-status).name}"
        last = self._last_line()
        return f"{self.name} ended with exit status {status}" + (f": {last}" if last else "")

    def _error_message(self) -> str:
        """Return the last line that a node printed, if that is an error message of its own; "" otherwise."""
        last = self._last_line()
        return last if last.startswith((*(f"{node}:" for node in self.nodes), "/")) else ""

    def _last_line(self) -> str:
        words = [line for line in self.log.read_text(errors="replace").splitlines() if line.strip()]
        return words[-1] if words else ""


class Launcher:
    """The node processes of one run, started in `forks`, processes that wait, as long as there are any, then each in a
    new Python.
    """

    def __init__(self, forks: list[Forked] | None = None) -> None:
        self._forks = forks or []
        self.nodes: list[NodeProcess] = []
        self._skips_grace = False

    def start(
        self,
        names: Sequence[str],
        scenario_file: Path,
        logs: Path,
        programs: Mapping[str, Sequence[str]] | None = None,
        namespace: str = "",
    ) -> None:
        """Start nodes with one parameter file.

        Parameters
        ----------
        names : of the nodes
        scenario_file : parameter file for all of them
        logs : folder; what each node prints goes to NAME.log in it
        programs : module and arguments that are started in the place of a node, by node
        namespace : in which the nodes live, with a clock of their own; "" for none
        """
        ros = [*_ros_arguments(scenario_file), *in_namespace(namespace)]
        for name in names:
            program = (programs or {}).get(name) or [PROCESS_BY_NAME[name].module]
            self._start(name, [name], [*program, *ros], logs)

    def start_composed(
        self, names: Sequence[str], scenario_file: Path, logs: Path, namespace: str = "", *, is_public: bool = False
    ) -> None:
        """Start the nodes `names` in one process, with `scenario_file`, `logs` and `namespace` as in `start`; other
        processes get every message where it `is_public`.
        """
        ros = [*_ros_arguments(scenario_file), *in_namespace(namespace)]
        self._start(TOGETHER, names, [*composed.program(names, is_public=is_public), *ros], logs)

    def _start(self, name: str, nodes: Sequence[str], program: list[str], logs: Path) -> None:
        logs.mkdir(parents=True, exist_ok=True)
        log = logs / f"{'nodes' if name == TOGETHER else name}.log"
        environment = {**ALLOCATOR, **os.environ, **parents_death.environment()}
        process: subprocess.Popen[bytes] | Forked
        with log.open("wb") as sink:
            if self._forks:
                process = self._forks.pop()
                process.run(log.stem, *program, log=log, environment=environment)
            else:
                process = subprocess.Popen(
                    parents_death.command(*program),
                    stdin=subprocess.DEVNULL,
                    stdout=sink,
                    stderr=subprocess.STDOUT,
                    env=environment,
                    start_new_session=True,  # a Ctrl-C in the terminal is passed on in order, not to all at once
                )
        self.nodes.append(NodeProcess(name, process, log, nodes))

    def failed(self) -> list[NodeProcess]:
        """Return the nodes that have ended before their work was done."""
        return [node for node in self.nodes if node.has_failed]

    def left(self) -> list[NodeProcess]:
        """Return the nodes that have ended as if their work were done."""
        return [node for node in self.nodes if node.has_left]

    def has_left(self, name: str) -> bool:
        """Return whether the process of this `name` has ended with its work done."""
        return any(node.name == name for node in self.left())

    def running(self) -> list[str]:
        """Return the names of the nodes that have not ended."""
        return [node.name for node in self.nodes if node.process.poll() is None]

    def all_ended(self) -> bool:
        """Return whether no node runs any more."""
        return not self.running()

    def skip_grace(self, *_: object) -> None:
        """End nodes without grace from now on; a signal handler."""
        self._skips_grace = True

    def stop(self, grace: float | None = None) -> None:
        """End every node: SIGINT, then `grace` seconds of wall time, for None as long as it may need, then SIGKILL."""
        for node in self.nodes:
            if node.process.poll() is None:
                node.process.send_signal(signal.SIGINT)
        asked = time.monotonic()
        while not self.all_ended():
            for node in self.nodes:
                allowed = node.grace if grace is None else grace
                is_due = self._skips_grace or time.monotonic() - asked >= allowed
                if is_due and node.process.poll() is None:
                    node.process.kill()
                    node.process.wait()
            time.sleep(0.02)


def _ros_arguments(scenario_file: Path) -> list[str]:
    return ["--ros-args", "--params-file", str(scenario_file)]
