"""Bags as a user names them: the bag's folder, or the folder of the run that holds it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from heave_bags.mcap.read.folder import is_bag


def bag_folders(paths: Sequence[Path]) -> list[Path]:
    """Return the bag folders meant by `paths`; a fault in one is reported when it is read."""
    return [path / "bag" if is_bag(path / "bag") and not is_bag(path) else path for path in paths]
