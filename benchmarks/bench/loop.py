"""The whole loop over ROS: its speed in lockstep, and how late it is in real time beside the machine's own stalls."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from pathlib import Path

import psutil
from heave_bags.analyse.reading.last_words import last_words
from heave_bags.mcap.reader import Bag
from heave_bringup.run.launcher import Launcher
from heave_bringup.run.run import Composed, RunFolder, run_scenario
from heave_bringup.scenarios import load_scenario
from heave_msgs.msg import TickStatus

from benchmarks.bench.stalls import stalls

SCENARIO = "b2_calm_300"


def measure_loop(duration: float, say: Callable[[str], None], composed: Composed | None = None) -> dict[str, object]:
    """Run a scenario with recording, and measure its speed.

    Parameters
    ----------
    duration : simulated time [s]
    say : called with what is being measured
    composed : in one process; None: in one for each node

    Returns `ticks_per_s`, `real_time_factor`, `loop_age_p50_s`, `loop_age_p99_s`, `resends`, `processes` (their
    number), and `cpu_ms_per_tick` by process. The sum of the latter over the number of processors is the least time
    that a tick can take.
    """
    processes = "a process for each node" if composed is None else "all nodes in one process"
    say(f"loop: {SCENARIO}, {duration:g} s in lockstep, {processes}")
    scenario = load_scenario(SCENARIO, settings=(f"all.duration={duration}", "all.transient=0.0"))
    with tempfile.TemporaryDirectory() as folder:
        usage = CpuUsage()
        status = run_scenario(scenario, RunFolder(Path(folder)), on_look=usage.look, composed=composed).status
    ticks = scenario.run.tick_count
    period = scenario.run.tick_period
    return {
        "scenario": scenario.name,
        "ticks": ticks,
        "ticks_per_s": status.real_time_factor / period,
        "real_time_factor": status.real_time_factor,
        "loop_age_p50_s": status.loop_age_p50,
        "loop_age_p99_s": status.loop_age_p99,
        "resends": int(status.resends),
        "processes": len(usage.seconds),
        "cpu_ms_per_tick": {name: 1e3 * seconds / ticks for name, seconds in usage.seconds.items()},
    }


def measure_realtime(
    rate: float, duration: float, say: Callable[[str], None], composed: Composed | None = None
) -> dict[str, object]:
    """Run a scenario in real time with recording, and measure how late it is.

    Parameters
    ----------
    rate : of the control loop [Hz]
    duration : of the run [s]
    say : called with what is being measured
    composed : in one process; None: in one for each node

    Returns `rate_hz`, `duration_s`, `composed`, `loop_age_p50_s`, `loop_age_p99_s`, `loop_age_max_s`,
    `missed_deadlines`, `cpu_ms_per_tick` by process, `histograms_ms` of the loop age and of each node's work in a tick,
    by upper edge, `load` (of the machine, over the last minute) and `stalls` of a process that only sleeps.
    """
    say(f"real time: {SCENARIO}, {rate:g} Hz for {duration:g} s")
    settings = (
        *("all.pacing=realtime", f"all.tick_period={1.0 / rate:.9g}", f"all.duration={duration}", "all.transient=0.0"),
    )
    scenario = load_scenario(SCENARIO, settings=settings)
    with tempfile.TemporaryDirectory() as folder:
        usage, run = CpuUsage(), RunFolder(Path(folder))
        with stalls() as of_machine:
            status = run_scenario(scenario, run, on_look=usage.look, composed=composed).status
        histograms = last_words(Bag(run.bag), is_paced=True).timings
    ticks = scenario.run.tick_count
    return {
        "rate_hz": rate,
        "duration_s": duration,
        "composed": composed is not None,
        "loop_age_p50_s": status.loop_age_p50,
        "loop_age_p99_s": status.loop_age_p99,
        "loop_age_max_s": status.loop_age_max,
        "missed_deadlines": int(status.missed_deadlines),
        "cpu_ms_per_tick": {name: 1e3 * seconds / ticks for name, seconds in usage.seconds.items()},
        "histograms_ms": histograms,
        "load": os.getloadavg()[0],
        "stalls": of_machine,
    }


class CpuUsage:
    """Processor time of each node process since the first tick."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._before: dict[str, float] = {}

    def look(self, launcher: Launcher, status: TickStatus | None) -> None:
        """Read the processor time of every node that still runs.

        Parameters
        ----------
        launcher : that has the processes
        status : the master's newest; None before the first
        """
        if status is None or status.state != TickStatus.RUNNING:
            return
        for node in launcher.nodes:
            try:
                times = psutil.Process(node.process.pid).cpu_times()
            except psutil.NoSuchProcess:
                continue
            used = times.user + times.system
            self._before.setdefault(node.name, used)
            self.seconds[node.name] = used - self._before[node.name]
