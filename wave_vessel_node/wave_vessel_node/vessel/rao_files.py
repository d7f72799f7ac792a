"""RAO tables from files: CSV (read and written) and Capytaine's NetCDF database (extra `capytaine`).

CSV: comment lines begin with #, then a header and one row for each speed, heading and frequency, in any order, the
grid complete. Columns: speed_mps, heading_rad, omega_radps, and for each of surge, sway, heave, roll, pitch, yaw an
amplitude (surge_m_per_m, roll_rad_per_m, ...) and a phase lead over the wave crest (surge_phase_rad, ...). Conventions:
see `rao`.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Sequence
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from heave_node.extras import how_to_install
from heave_node.files.given_files import read_given
from heave_node.numerics.arrays import Array, ComplexArray
from scipy.interpolate import CubicSpline

from wave_vessel_node.vessel.motion import DEGREES_OF_FREEDOM
from wave_vessel_node.vessel.rao import RaoError, ResponseTable, encounter_frequency

SHIPPED_TABLE = "wigley_90m.csv"
_GRID = ("speed_mps", "heading_rad", "omega_radps")
_UNITS = ("m_per_m", "m_per_m", "m_per_m", "rad_per_m", "rad_per_m", "rad_per_m")
_AMPLITUDES = tuple(f"{name}_{unit}" for name, unit in zip(DEGREES_OF_FREEDOM, _UNITS, strict=True))
_PHASES = tuple(f"{name}_phase_rad" for name in DEGREES_OF_FREEDOM)
_STATION_KEEPING_PERIOD = 120.0  # s
_STATION_KEEPING_DAMPING = 0.3  # of critical
COLUMNS = (*_GRID, *(column for pair in zip(_AMPLITUDES, _PHASES, strict=True) for column in pair))


def shipped_rao() -> ResponseTable:
    """Return the RAOs of the hull form that ships with the package (see the comments in its file)."""
    with resources.as_file(resources.files("wave_vessel_node") / "data" / SHIPPED_TABLE) as path:
        return read_rao_csv(path)


def read_rao(path: str | Path, speeds: Sequence[float] = (0.0,)) -> ResponseTable:
    """Read a table.

    Parameters
    ----------
    path : ends in .csv or .nc; empty takes the hull form that ships with the package
    speeds : forward speeds [m/s] of the table that is made of a Capytaine database (.nc); a .csv has its own

    Raises RaoError when the file is missing, of another kind or broken.
    """
    if not str(path):
        return shipped_rao()
    path = Path(path)
    if not path.is_file():
        raise RaoError(f"{path}: no such file")
    if path.suffix.lower() == ".csv":
        return read_rao_csv(path)
    if path.suffix.lower() in (".nc", ".nc4"):
        return read_capytaine(path, speeds=speeds)
    raise RaoError(f"{path}: expected an RAO table (.csv) or a Capytaine database (.nc)")


def read_rao_csv(path: str | Path) -> ResponseTable:
    """Read the CSV table at `path`; see the module for its columns. Raises RaoError, with the line."""
    path = Path(path)
    try:
        text = read_given(path)
    except ValueError as error:
        raise RaoError(f"{path}: {error}") from error
    numbered = [(n, line) for n, line in enumerate(text.splitlines(), 1) if line.strip() and not line.startswith("#")]
    if len(numbered) < 2:
        raise RaoError(f"{path}: expected a header and rows, found {len(numbered)} lines")
    rows = list(csv.reader(line for _, line in numbered))
    header = [name.strip() for name in rows[0]]
    missing = [name for name in COLUMNS if name not in header]
    if missing:
        raise RaoError(f"{path}: line {numbered[0][0]}: {_without_columns(missing, numbered[0][1])}")
    values = np.empty((len(rows) - 1, len(COLUMNS)))
    positions = [header.index(name) for name in COLUMNS]
    for index, ((number, _), row) in enumerate(zip(numbered[1:], rows[1:], strict=True)):
        if len(row) != len(header):
            raise RaoError(f"{path}: line {number}: {len(row)} values where the header has {len(header)} columns")
        for column, position in enumerate(positions):
            values[index, column] = _number(row[position], f"{path}: line {number}: {COLUMNS[column]}")
    return _grid_table(path, values)


def _without_columns(missing: Sequence[str], header: str) -> str:
    """Say what is wrong with a `header` in which columns are `missing`."""
    if len(missing) < len(COLUMNS):
        return f"missing columns {', '.join(missing)}"
    separator = next((name for sign, name in ((";", "semicolons"), ("\t", "tabs")) if sign in header), "")
    found = f"the columns are parted by {separator}: " if separator else ""
    return f"{found}expected commas, decimal points, and the header {','.join(COLUMNS)}"


def _number(text: str, where: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise RaoError(f"{where}: {text!r} is not a number") from None
    if not math.isfinite(value):
        raise RaoError(f"{where}: {text!r} is not a finite number")
    return value


def _grid_table(path: Path, values: Array) -> ResponseTable:
    """Put the rows on their grid; each point must be there once."""
    axes = [np.unique(values[:, column]) for column in range(3)]
    shape = tuple(axis.size for axis in axes)
    index = [np.searchsorted(axis, values[:, column]) for column, axis in enumerate(axes)]
    count = np.zeros(shape, dtype=int)
    np.add.at(count, tuple(index), 1)
    if (count != 1).any():
        where = np.argwhere(count != 1)[0]
        point = ", ".join(f"{name} {axis[i]:g}" for name, axis, i in zip(_GRID, axes, where, strict=True))
        found = "missing" if count[tuple(where)] == 0 else "repeated"
        raise RaoError(f"{path}: the grid of speeds, headings and frequencies is not complete: {point} is {found}")
    amplitude, phase = values[:, 3::2], values[:, 4::2]
    if (amplitude < 0.0).any():
        raise RaoError(f"{path}: an amplitude is negative ({amplitude.min():g}): shift its phase by pi instead")
    response = np.empty((*shape, 6), dtype=complex)
    response[tuple(index)] = amplitude * np.exp(1j * phase)
    try:
        return ResponseTable(axes[0], axes[1], axes[2], np.ascontiguousarray(np.swapaxes(response, 2, 3)))
    except RaoError as error:
        raise RaoError(f"{path}: {error}") from error


def write_rao_csv(path: str | Path, table: ResponseTable, comments: Iterable[str] = ()) -> None:
    """Write at `path` a `table` that `read_rao_csv` reads; `comments` go before it."""
    lines = [f"# {comment}".rstrip() for comment in comments]
    lines.append(",".join(COLUMNS))
    for s, speed in enumerate(table.speed):
        for h, heading in enumerate(table.heading):
            for f, omega in enumerate(table.frequency):
                motion = table.response[s, h, :, f]
                numbers = [f"{speed:g}", f"{heading:.6f}", f"{omega:g}"]
                for value in motion:
                    numbers += [f"{abs(value):.4e}", f"{np.angle(value):.4f}"]
                lines.append(",".join(numbers))
    Path(path).write_text("\n".join(lines) + "\n", encoding="utf-8")


def read_capytaine(
    path: str | Path,
    *,
    speeds: Sequence[float] = (0.0,),
    roll_damping: float = 0.05,
    frequencies: Sequence[float] | Array | None = None,
) -> ResponseTable:
    """Make RAOs of the added mass, damping, excitation, inertia and stiffness in a Capytaine database.

    Parameters
    ----------
    path : of the NetCDF file
    speeds : forward speeds [m/s]; added mass and damping are then those of the encounter frequency, excitation that of
        zero speed
    roll_damping : fraction of critical added to roll, for what potential flow lacks
    frequencies : of the table [rad/s]; default: those of the database with three more between each two.
        Coefficients are smooth and interpolated well; motions have resonances, which need the finer steps

    A soft position keeping (natural period 120 s) holds surge, sway and yaw, which would have no bound where the
    encounter frequency is 0.

    Raises RaoError when xarray is not installed, or the file lacks what is needed.
    """
    dataset = _open_dataset(Path(path))
    try:
        order = [_dof_label(dataset, name) for name in DEGREES_OF_FREEDOM]
        radiation = {"radiating_dof": order, "influenced_dof": order}
        grid = ("omega", "influenced_dof", "radiating_dof")
        added_mass = dataset["added_mass"].sel(radiation).transpose(*grid).to_numpy()
        damping = dataset["radiation_damping"].sel(radiation).transpose(*grid).to_numpy()
        inertia = dataset["inertia_matrix"].sel(radiation).transpose(*grid[1:]).to_numpy()
        stiffness = dataset["hydrostatic_stiffness"].sel(radiation).transpose(*grid[1:]).to_numpy()
        excitation = _excitation(dataset, order)
        omega = dataset["omega"].to_numpy().astype(float)
        heading = dataset["wave_direction"].to_numpy().astype(float)
    except (KeyError, ValueError) as error:
        raise RaoError(f"{path}: is not a complete Capytaine database: {str(error).splitlines()[0]}") from error
    coefficients = (added_mass, damping, inertia, stiffness)
    if not all(np.isfinite(values).all() for values in (*coefficients, excitation)):
        raise RaoError(f"{path}: the database has coefficients that are not finite")
    if frequencies is None:
        frequencies = np.interp(np.arange(4 * omega.size - 3) / 4.0, np.arange(omega.size), omega)
    fine = np.asarray(frequencies, dtype=float)
    if fine.min() < omega[0] - 1e-9 or fine.max() > omega[-1] + 1e-9:
        raise RaoError(f"{path}: has frequencies {omega[0]:g} to {omega[-1]:g} rad/s: the table must lie within")
    force = np.asarray(CubicSpline(omega, excitation, axis=1)(fine))
    response = [_motions(fine, omega, heading, coefficients, force, speed, roll_damping) for speed in speeds]
    return ResponseTable(np.array(speeds, dtype=float), heading, fine, np.array(response))


def _open_dataset(path: Path) -> Any:
    if not path.is_file():
        raise RaoError(f"{path}: no such file")
    try:
        import xarray  # noqa: PLC0415  an extra: only needed for these files
    except ImportError as error:
        raise RaoError(f"{path}: reading Capytaine's NetCDF needs xarray; {how_to_install('capytaine')}") from error
    try:
        with xarray.open_dataset(path) as dataset:
            loaded = dataset.load()
    except (OSError, ValueError) as error:
        raise RaoError(f"{path}: cannot be read as NetCDF: {str(error).splitlines()[0]}") from error
    for name in ("radiating_dof", "influenced_dof", "complex"):
        if name in loaded.coords:
            labels = [label.decode() if isinstance(label, bytes) else str(label) for label in loaded[name].to_numpy()]
            loaded = loaded.assign_coords({name: labels})
    return loaded.sortby(["omega", "wave_direction"])


def _dof_label(dataset: Any, name: str) -> str:
    """Return the database's label of the degree of freedom `name`, in capitals or not."""
    labels = [str(label) for label in dataset["influenced_dof"].to_numpy()]
    for label in labels:
        if label.lower() == name:
            return label
    raise KeyError(f"degree of freedom {name} (found {', '.join(labels)})")


def _excitation(dataset: Any, order: Sequence[str]) -> ComplexArray:
    """Return the excitation force (heading, omega, 6) in convention e^{+i omega t}; Capytaine's is e^{-i omega t}."""
    force = dataset["Froude_Krylov_force"] + dataset["diffraction_force"]
    force = force.sel(influenced_dof=list(order)).transpose("complex", "wave_direction", "omega", "influenced_dof")
    real, imaginary = force.sel(complex="re").to_numpy(), force.sel(complex="im").to_numpy()
    return np.asarray(real - 1j * imaginary)


def _motions(
    frequency: Array,
    omega: Array,
    heading: Array,
    coefficients: tuple[Array, Array, Array, Array],
    excitation: ComplexArray,
    speed: float,
    roll_damping: float,
) -> ComplexArray:
    """Return H (heading, 6, frequency) of (-w^2 (M + A(w)) + i w B(w) + C) H = F, w the encounter frequency.

    Added mass and damping are given at `omega`, the excitation at `frequency`.
    """
    added_mass, damping, inertia, stiffness = coefficients
    keeping, viscous = _added_by_hand(omega, coefficients, roll_damping)
    mass_at, damping_at = CubicSpline(omega, added_mass, axis=0), CubicSpline(omega, damping, axis=0)
    response = np.empty((heading.size, 6, frequency.size), dtype=complex)
    for h, angle in enumerate(heading):
        encounter = encounter_frequency(frequency, angle, speed)[:, None, None]
        at = np.clip(np.abs(encounter[:, 0, 0]), omega[0], omega[-1])
        impedance = (
            -(encounter**2) * (inertia + mass_at(at))
            + 1j * encounter * (damping_at(at) + viscous)
            + stiffness
            + keeping
        )
        response[h] = np.linalg.solve(impedance, excitation[h][:, :, None])[:, :, 0].T
    return response


def _added_by_hand(
    omega: Array, coefficients: tuple[Array, Array, Array, Array], roll_damping: float
) -> tuple[Array, Array]:
    """Return stiffness and damping that potential flow lacks: position keeping, and viscous roll damping."""
    added_mass, _, inertia, stiffness = coefficients
    keeping, viscous = np.zeros((6, 6)), np.zeros((6, 6))
    keeping_frequency = 2.0 * math.pi / _STATION_KEEPING_PERIOD
    for motion in (0, 1, 5):  # surge, sway, yaw have no restoring of their own
        keeping[motion, motion] = inertia[motion, motion] * keeping_frequency**2
        viscous[motion, motion] = 2.0 * _STATION_KEEPING_DAMPING * inertia[motion, motion] * keeping_frequency
    dry_frequency = math.sqrt(max(stiffness[3, 3], 0.0) / inertia[3, 3])
    roll_inertia = inertia[3, 3] + np.interp(dry_frequency, omega, added_mass[:, 3, 3])
    viscous[3, 3] = 2.0 * roll_damping * math.sqrt(max(stiffness[3, 3], 0.0) * roll_inertia)
    return keeping, viscous
