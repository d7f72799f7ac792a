"""How long the machine itself stops a program that only sleeps: `python -m benchmarks.bench.stalls`."""

from __future__ import annotations

import json
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

from heave_node.tick.durations import Durations

PERIOD = 0.001
"""Time for which the program sleeps each time [s]."""


@contextmanager
def stalls() -> Iterator[dict[str, object]]:
    """Let a process that only sleeps run beside what is within; the result is filled at its end.

    It holds p50, p99 and the largest time by which a sleep took longer than it should, `p50_s`, `p99_s`, `max_s`, and
    their histogram, `histogram_ms`, by upper edge.
    """
    found: dict[str, object] = {}
    sleeper = subprocess.Popen(
        [sys.executable, "-m", "benchmarks.bench.stalls"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    try:
        yield found
    finally:
        said, _ = sleeper.communicate("end\n")
        found |= json.loads(said)


def main() -> None:
    """Sleep until standard input says something, and print by how much each sleep was too long."""
    is_over = threading.Event()

    def wait() -> None:
        sys.stdin.readline()
        is_over.set()

    threading.Thread(target=wait, daemon=True).start()
    late = Durations()
    while not is_over.is_set():
        began = time.monotonic()
        time.sleep(PERIOD)
        late.add(time.monotonic() - began - PERIOD)
    p50, p99, largest = late.percentiles()
    json.dump({"p50_s": p50, "p99_s": p99, "max_s": largest, "histogram_ms": late.histogram()}, sys.stdout)


if __name__ == "__main__":
    main()
