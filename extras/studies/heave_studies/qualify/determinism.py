"""Whether equal runs give equal results: hashes of short runs, repeated in one process and in new ones.

`python -m heave_studies.qualify.determinism` prints those of one process.
"""

from __future__ import annotations

import hashlib
import json
import platform
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from heave_bags.record.provenance import versions
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.errors import CommandError
from heave_bringup.progress import ProgressLine
from heave_bringup.scenarios import load_scenario

SCENARIOS = ("b2_calm_300", "b3_deep_900")
DURATION, REPEATS = 60.0, 2
"""Simulated time of a run [s], and runs in each process."""


def hash_of(scenario: str) -> str:
    """Return the SHA-256 of all that a run of a `scenario` records, every bit of it, to 16 digits."""
    loop = ClosedLoop(replace(loop_parameters(load_scenario(scenario)), duration=DURATION))
    return hashlib.sha256(np.ascontiguousarray(loop.run().rows).tobytes()).hexdigest()[:16]


def machine() -> str:
    """Return what may make a difference: processor, system, versions of Python, numpy and numba."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text(encoding="utf-8").splitlines() if info.is_file() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    libraries = [f"{name} {version}" for name, version in versions().items() if name in ("python", "numpy", "numba")]
    system = f"{platform.system()} {platform.machine()} {' '.join(platform.libc_ver())}"
    return ", ".join([*(names[:1] or [platform.processor()]), system, *libraries])


def run_hashes(folder: Path, processes: int) -> list[Mapping[str, Any]]:
    """Return the hashes of so many `processes`, and those of other machines and Pythons that are in the `folder`.

    Each machine and Python has a file in the folder: repeat the command there, or copy the file from another one.

    Raises CommandError where a process fails.
    """
    here = machine()
    hashes: dict[str, list[str]] = {name: [] for name in SCENARIOS}
    with ProgressLine() as line:
        for number in range(processes):
            line.show(f"determinism: process {number + 1} of {processes}", number / processes)
            done = subprocess.run([sys.executable, "-m", __name__], capture_output=True, text=True, check=False)
            if done.returncode:
                raise CommandError(f"determinism: a run failed: {' '.join(done.stderr.split())[-200:]}")
            for name, values in json.loads(done.stdout.splitlines()[-1]).items():
                hashes[name] += values
    own = folder / f"determinism_{hashlib.sha256(here.encode()).hexdigest()[:8]}.json"
    own.write_text(json.dumps({"machine": here, "hashes": hashes}, indent=1), encoding="utf-8")
    files = [own, *sorted(path for path in folder.glob("determinism_*.json") if path != own)]
    return [json.loads(path.read_text(encoding="utf-8")) for path in files]


def differences(found: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return the scenarios whose runs on the first machine of those `found` differ, in words."""
    own = found[0]["hashes"] if found else {}
    return [f"determinism: runs of {name} differ" for name, values in own.items() if len(set(values)) != 1]


if __name__ == "__main__":
    sys.stdout.write(json.dumps({name: [hash_of(name) for _ in range(REPEATS)] for name in SCENARIOS}) + "\n")
