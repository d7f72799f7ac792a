"""What killed processes leave in the shared memory of the machine, and which of it is safe to remove.

Fast DDS keeps a segment for each participant, `fastdds_<16 hex digits>`. Beside it lies a lock file, `_el` or `_sl`,
which the kernel (flock) holds locked as long as the process lives that owns it; a process that is stopped, of another
user or in another container holds its lock like any other. So a lock that can be taken proves that nothing uses what it
guards, and while it is held here nothing can begin to. A file without a lock file proves nothing, and is left.

The queues of ports, `fastdds_port<N>`, are left as well: their names are used again, by all domains, and a process that
has opened one and not yet locked it would listen to a queue that nobody finds. They are small, of a bounded number, and
Fast DDS replaces a dead one.
"""

from __future__ import annotations

import fcntl
import os
import re
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

SHARED_MEMORY = Path("/dev/shm")

MINIMUM_AGE = 10.0
"""Files that are younger may be half made [s]: Fast DDS creates a lock file first and takes the lock then."""

_LOCK = re.compile(r"(?P<guarded>fastdds_[0-9a-f]{16})_[es]l")


def remove_dead_segments(folder: Path = SHARED_MEMORY, minimum_age: float = MINIMUM_AGE) -> list[str]:
    """Remove what processes of this user that are dead left in shared memory; return the names, sorted.

    Nothing of a living process or of another user is touched, and nothing that is younger than `minimum_age` [s]. Does
    nothing on systems without `folder`.
    """
    removed = []
    for lock in sorted(folder.glob("fastdds_*")) if folder.is_dir() else []:
        match = _LOCK.fullmatch(lock.name)
        if match is None or not _is_ours_and_old(lock, minimum_age):
            continue
        with _taken(lock) as is_dead:
            if is_dead:
                removed += _remove(folder / match["guarded"], lock)
    return sorted(removed)


def _is_ours_and_old(lock: Path, minimum_age: float) -> bool:
    with suppress(OSError):
        status = lock.stat(follow_symlinks=False)
        return status.st_uid == os.geteuid() and time.time() - status.st_mtime >= minimum_age
    return False


@contextmanager
def _taken(lock: Path) -> Iterator[bool]:
    """Try to take a lock for as long as the context lasts, and tell whether it is taken."""
    try:
        descriptor = os.open(lock, os.O_RDONLY | os.O_NOFOLLOW)
    except OSError:
        yield False
        return
    try:
        yield _is_lockable(descriptor) and _is_still(lock, descriptor)
    finally:
        os.close(descriptor)


def _is_lockable(descriptor: int) -> bool:
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def _is_still(lock: Path, descriptor: int) -> bool:
    """Return whether a name still refers to the open file: another may have been made in its place meanwhile."""
    with suppress(OSError):
        return os.path.samestat(lock.stat(follow_symlinks=False), os.fstat(descriptor))
    return False


def _remove(*files: Path) -> list[str]:
    removed = []
    for file in files:
        with suppress(OSError):
            file.unlink()
            removed.append(file.name)
    return removed
