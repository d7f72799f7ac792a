"""Where a bag comes from: scenario, versions of the software, git commit, host and its clock."""

from __future__ import annotations

import platform
import subprocess
import time
from collections.abc import Sequence
from importlib import metadata
from pathlib import Path

from heave_bags.errors import BagError
from heave_bags.mcap.bag_writer import Attachment

LIBRARIES = ("heave", "heave_bags", "ros-rclpy", "rclpy", "numpy", "scipy", "numba", "mcap", "control")
SCENARIO_ATTACHMENT = "scenario.yaml"
PARAMETERS_ATTACHMENT = "parameters.yaml"
"""The parameters that all nodes had in a run, defaults included."""


def versions() -> dict[str, str]:
    """Return the versions of Python, of this project and of the libraries that its results depend on."""
    found = {name: _version(name) for name in LIBRARIES}
    return {"python": platform.python_version(), **{name: version for name, version in found.items() if version}}


def _version(distribution: str) -> str:
    try:
        return metadata.version(distribution)
    except metadata.PackageNotFoundError:
        return ""


def git_commit(folder: Path | None = None) -> str:
    """Return the commit of the source tree in `folder` (None: of what runs); "" outside of a git tree.

    "+changes" is appended where files differ.
    """
    folder = folder or Path(__file__).resolve().parent
    try:
        commit = _git(folder, "rev-parse", "HEAD")
        changed = _git(folder, "status", "--porcelain", "--untracked-files=no")
    except (OSError, subprocess.SubprocessError):
        return ""
    return commit + ("+changes" if changed else "")


def _git(folder: Path, *arguments: str) -> str:
    done = subprocess.run(
        ["git", "-C", str(folder), *arguments], capture_output=True, text=True, check=True, timeout=5.0
    )
    return done.stdout.strip()


def describe_run(
    *,
    scenario: str,
    seed: int,
    pacing: str,
    tick_period: float,
    transient: float,
    composed: bool = False,
    replaced: Sequence[str] = (),
) -> dict[str, str]:
    """Return what the metadata of a bag says of the run it holds.

    Parameters
    ----------
    scenario : file
    seed : of the run
    pacing : "lockstep" or "realtime"
    tick_period, transient : [s]
    composed : all nodes share one process
    replaced : nodes in whose place a bag (NODE=bag) or another program takes part
    """
    return {
        "scenario": scenario,
        "seed": str(seed),
        "pacing": pacing,
        "tick_period_s": repr(tick_period),
        "transient_s": repr(transient),
        "composed": str(composed).lower(),
        "replaced": " ".join(replaced),
        "git_commit": git_commit(),
        "host": platform.node(),
        "machine": f"{platform.system()} {platform.release()} {platform.machine()}",
        "started_at_host_time_ns": str(time.time_ns()),
        **{f"version.{name}": version for name, version in versions().items()},
    }


def scenario_attachments(path: str) -> list[Attachment]:
    """Return the parameter file `path` of a run as an attachment; none for "". Raises BagError if it cannot be read."""
    try:
        return [Attachment(SCENARIO_ATTACHMENT, "application/yaml", Path(path).read_bytes())] if path else []
    except OSError as error:
        raise BagError(f"scenario_file {path}: cannot be read: {error.strerror}") from error
