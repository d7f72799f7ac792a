"""Compiled kernels on disk must not outlive their sources.

Numba's cache looks only at the file a function stands in, not at the files of the functions it calls. Here
kernels call one another across files, so an edit of one would leave stale machine code of its callers in use.
`drop_stale` deletes what is older than any of the sources.
"""

from __future__ import annotations

import contextlib
from pathlib import Path


def drop_stale(patterns: tuple[str, ...], folder: Path = Path(__file__).parent) -> None:
    """Delete the cache entries of the modules in `folder` that match `patterns` (such as "line_*") if any of those
    sources is newer.
    """
    sources = [path for pattern in patterns for path in folder.glob(f"{pattern}.py")]
    newest = max(path.stat().st_mtime for path in sources)
    for pattern in patterns:
        for index in (folder / "__pycache__").glob(f"{pattern}.*.nbi"):
            # several processes start at once: another may have been quicker
            with contextlib.suppress(OSError):
                if index.stat().st_mtime < newest:
                    index.unlink()
