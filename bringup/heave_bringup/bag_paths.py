"""Bags as a user names them: the bag's folder, or the folder of the run that holds it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path


def bag_folders(paths: Sequence[Path]) -> list[Path]:
    """Return the bag folders meant by `paths`; a fault in one is reported when it is read."""
    return [path / "bag" if _is_bag(path / "bag") and not _is_bag(path) else path for path in paths]


def _is_bag(folder: Path) -> bool:
    """Return whether a folder holds a bag; a damaged one may have lost its index."""
    return (folder / "metadata.yaml").is_file() or any(folder.glob("*.mcap"))
