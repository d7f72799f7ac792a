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
import time
from contextlib import suppress
from pathlib import Path

SHARED_MEMORY = Path("/dev/shm")

MINIMUM_AGE = 10.0
"""Files that are younger may be half made [s]: Fast DDS creates a lock file first and takes the lock then."""

_LOCKS = "fastdds_" + 16 * "[0-9a-f]" + "_[es]l"


def remove_dead_segments(folder: Path = SHARED_MEMORY, minimum_age: float = MINIMUM_AGE) -> list[str]:
    """Remove what processes of this user that are dead left in shared memory; return the names, sorted.

    Nothing of a living process or of another user is touched, and nothing that is younger than `minimum_age` [s]. Does
    nothing on systems without `folder`.
    """
    removed: list[str] = []
    for lock in folder.glob(_LOCKS):
        with suppress(OSError):
            found = lock.stat(follow_symlinks=False)
            if found.st_uid == os.geteuid() and time.time() - found.st_mtime >= minimum_age:
                removed += _remove_if_dead(lock)
    return sorted(removed)


def _remove_if_dead(lock: Path) -> list[str]:
    """Remove a `lock` that nobody holds, and what it guards. Raises OSError where somebody does."""
    removed = []
    descriptor = os.open(lock, os.O_RDONLY | os.O_NOFOLLOW)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if os.path.samestat(lock.stat(), os.fstat(descriptor)):  # another may have been made in its place meanwhile
            for file in (lock.with_name(lock.name[:-3]), lock):
                with suppress(OSError):
                    file.unlink()
                    removed.append(file.name)
    finally:
        os.close(descriptor)
    return removed
