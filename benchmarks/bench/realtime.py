"""Loop age and missed deadlines in real time, five processes, adviser and recorder, beside the machine's own stalls."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from pathlib import Path

from heave_bags.analyse.reading.last_words import last_words
from heave_bags.mcap.reader import Bag
from heave_bringup.run.run import Composed, RunFolder, run_scenario
from heave_bringup.scenarios import load_scenario

from benchmarks.bench.loop import SCENARIO, CpuUsage
from benchmarks.bench.stalls import stalls


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
