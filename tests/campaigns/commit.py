"""What a campaign was measured on."""

from __future__ import annotations

import os
import platform
from pathlib import Path

from heave_bags.record.provenance import git_commit


def commit_line() -> str:
    """Return the commit that runs, Python and processors, in one line."""
    commit = git_commit(Path(__file__).parent) or "no commit known"
    return f"measured on {commit}, Python {platform.python_version()}, {os.cpu_count()} processors"
