"""The published records of ship motion, where a user has them: they are not shipped.

A record is `zinage_NAME.csv` (header, then time [s], heave [m, positive up]) or `NAME.mat` of the public repository
`shrenikvz/active-heave-compensation` (MIT), NAME slight, moderate or rough: a variable `response1` of two columns. They
may lie anywhere below the folder.
"""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.parameters import ParameterError
from scipy.io import loadmat

FOLDER_VARIABLE = "HEAVE_BENCHMARK_RECORDS"
"""Environment variable that names the folder where the option does not."""
LENGTH = 1200.0
"""Part of a record that is used [s]."""
HOW = (
    "give the folder of a checkout of github.com/shrenikvz/active-heave-compensation with --records, or in "
    f"{FOLDER_VARIABLE}"
)


@dataclass(frozen=True)
class HeaveRecord:
    """A record.

    Attributes
    ----------
    time : [s], shape (n,), equally spaced from 0
    heave : [m], shape (n,), positive up
    digest : identifies the record
    """

    time: Array
    heave: Array
    digest: str


def records_folder(option: Path | None) -> Path | None:
    """Return the folder of records: the option's, else the environment's; None where neither says."""
    if option is not None:
        if not option.is_dir():
            raise ParameterError(f"--records {option}: no such folder")
        return option
    named = os.environ.get(FOLDER_VARIABLE, "")
    if named and not Path(named).is_dir():
        raise ParameterError(f"{FOLDER_VARIABLE}={named}: no such folder")
    return Path(named) if named else None


def find_record(folder: Path | None, name: str) -> Path | None:
    """Return the file of the record `name` anywhere below `folder`, None where there is none."""
    if folder is None:
        return None
    files = [*sorted(folder.rglob(f"zinage_{name}.csv")), *sorted(folder.rglob(f"{name}.mat"))]
    return files[0] if files else None


def read_record(path: Path) -> HeaveRecord:
    """Return the record in the file `path`; raises ParameterError, naming the file, for one that is not a record."""
    try:
        table = _read_matlab(path) if path.suffix == ".mat" else np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)
    # scipy does not read the HDF5 files of MATLAB 7.3, and reports that by the last of these
    except (OSError, ValueError, KeyError, NotImplementedError) as error:
        raise ParameterError(f"{path}: is not a record of time and heave: {' '.join(str(error).split())}") from error
    if table.ndim != 2 or table.shape[1] != 2 or table.shape[0] < 10 or not np.isfinite(table).all():
        raise ParameterError(f"{path}: must hold two columns of finite numbers, time and heave; got {table.shape}")
    used = table[table[:, 0] <= LENGTH + 1e-9]
    steps = np.diff(used[:, 0])
    if used[0, 0] != 0.0 or np.ptp(steps) > 1e-6 or steps[0] <= 0.0:
        raise ParameterError(f"{path}: times must begin at 0 and be equally spaced")
    rounded = np.round(used * [1e3, 1e6]).astype(np.int64)
    return HeaveRecord(used[:, 0], used[:, 1], hashlib.sha256(rounded.tobytes()).hexdigest()[:16])


def _read_matlab(path: Path) -> Array:
    return np.asarray(loadmat(path)["response1"], dtype=float)
