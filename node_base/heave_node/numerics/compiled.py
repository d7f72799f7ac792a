"""How hot loops are compiled: cached on disk, division by zero gives inf or NaN as in numpy.

The cache is beside the sources, or in the user's own; where neither can be written, as in a container with a read-only
root, in a folder of this user below the temporary one. `NUMBA_CACHE_DIR` names another.
"""

from __future__ import annotations

import contextlib
import os
import tempfile
from pathlib import Path
from typing import Any

from numba import njit
from numba.core import config

_WITHOUT_ENTRANCES: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}


def _is_writable(folder: Path) -> bool:
    """Return whether a file can be made in a `folder`, which is made where it is missing."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def temporary_cache(sources: Path) -> Path:
    """Return a folder of this user alone for what is compiled of the packages in the folder `sources`, as they are now.

    Machine code of another user is never run: a folder that is not this user's own is replaced by a new one.
    """
    files = (file for name in ("heave_*", "*_node") for file in sources.glob(f"{name}/**/*.py"))
    newest = max((round(file.stat().st_mtime) for file in files), default=0)
    cache = Path(tempfile.gettempdir()) / f"heave-kernels-{os.getuid()}-{newest}"
    with contextlib.suppress(OSError):
        cache.mkdir(mode=0o700)
    with contextlib.suppress(OSError):
        found = cache.lstat()
        if cache.is_dir() and not cache.is_symlink() and found.st_uid == os.getuid() and not found.st_mode & 0o077:
            return cache
    return Path(tempfile.mkdtemp(prefix="heave-kernels-"))


def _provide_cache(here: Path) -> None:
    """Let numba have a cache where it would find none, and this process's children the same."""
    home = Path(os.environ.get("HOME", "/nowhere"), ".cache")
    own = Path(os.environ.get("XDG_CACHE_HOME") or home)
    if os.environ.get("NUMBA_CACHE_DIR") or _is_writable(here / "__pycache__") or _is_writable(own):
        return
    os.environ["NUMBA_CACHE_DIR"] = str(temporary_cache(here.parents[1]))
    config.reload_config()  # type: ignore[no-untyped-call]


_provide_cache(Path(__file__).parent)

kernel = njit(cache=True, error_model="numpy")
"""A function that Python or other kernels call."""

inner_kernel = njit(cache=True, error_model="numpy", **_WITHOUT_ENTRANCES)
"""A function that kernels alone may call; from Python it would crash.

The way in from Python, which takes all arrays of a line apart, costs as much to compile as the function itself.
"""

inlined_kernel = njit(cache=True, error_model="numpy", forceinline=True, **_WITHOUT_ENTRANCES)
"""An inner kernel whose code is put where it is called, however long: for what must not wait for a call, or is to be
vectorised with its caller.
"""


@kernel
def _nothing() -> None:
    pass


def load() -> None:
    """Load what numba loads at the first call of a kernel: a third of a second."""
    _nothing()


def is_compiled(function: Any) -> bool:
    """Return whether the kernel `function` is in numba's cache: its first call in a process is then quick."""
    return any(Path(function.stats.cache_path).glob(f"*.{function.__name__}-*.nbi"))


def drop_stale_kernels(package_file: str, *used_files: str) -> None:
    """Delete the compiled kernels of a package folder that are older than any source that they are made of.

    Numba's cache looks only at the file a function is in, not at the files of the functions it calls. Kernels call
    one another across files, so an edit of one would leave stale machine code of its callers in use.

    Parameters
    ----------
    package_file : `__file__` of the folder's `__init__`, which runs before any of its kernels is loaded
    used_files : the same of other folders whose kernels are called from this one
    """
    folder = Path(package_file).parent
    sources = (path for file in (package_file, *used_files) for path in Path(file).parent.glob("*.py"))
    newest = max(path.stat().st_mtime for path in sources)
    for index in (folder / "__pycache__").glob("*.nbi"):
        # several processes start at once: another may have been quicker
        with contextlib.suppress(OSError):
            if index.stat().st_mtime < newest:
                index.unlink()
