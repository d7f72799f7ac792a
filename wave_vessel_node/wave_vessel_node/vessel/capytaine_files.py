"""RAO tables from Capytaine's NetCDF databases of added mass, damping and excitation (extra `capytaine`)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from heave_node.extras import how_to_install
from heave_node.numerics.arrays import Array, ComplexArray

from wave_vessel_node.vessel.motion import DEGREES_OF_FREEDOM
from wave_vessel_node.vessel.rao import MIRROR, RaoError, ResponseTable, between, encounter_frequency, judged

_STATION_KEEPING_PERIOD = 120.0  # s
_STATION_KEEPING_DAMPING = 0.3  # of critical
_AXES = {"omega", "wave_direction", "influenced_dof", "radiating_dof", "complex"}
_OMEGA_OF = {"omega": lambda x: x, "period": lambda x: 2.0 * math.pi / x, "freq": lambda x: 2.0 * math.pi * x}
"""Angular frequency [rad/s] of each coordinate over which a database may be."""
_SAME = 1e-6
"""Headings that differ by less are one [rad]."""


@dataclass(frozen=True)
class _Database:
    """The coefficients of a database, at frequencies and headings that rise, all finite."""

    omega: Array  # [rad/s], shape (f,)
    heading: Array  # 0 to below 2 pi [rad], shape (h,)
    coefficients: tuple[Array, Array, Array, Array]  # added mass and damping (f, 6, 6), inertia and stiffness (6, 6)
    excitation: ComplexArray  # in convention e^{+i omega t}, shape (h, f, 6)
    is_mirrored: bool  # the headings are those of waves from the other side
    notes: tuple[str, ...]  # what was left out or changed


def read_capytaine(
    path: str | Path,
    *,
    speeds: Sequence[float] = (0.0,),
    roll_damping: float = 0.05,
    frequencies: Sequence[float] | Array | None = None,
    accept_implausible: bool = False,
) -> ResponseTable:
    """Make RAOs of the added mass, damping, excitation, inertia and stiffness in a Capytaine database.

    Parameters
    ----------
    path : of the NetCDF file, over omega, period or freq
    speeds : forward speeds [m/s]; added mass and damping are then those of the encounter frequency, excitation that of
        zero speed
    roll_damping : fraction of critical added to roll, for what potential flow lacks
    frequencies : of the table [rad/s]; default: those of the database with three more between each two.
        Coefficients are smooth and interpolated well; motions have resonances, which need the finer steps
    accept_implausible : see `read_rao`

    A soft position keeping (natural period 120 s) holds surge, sway and yaw, which would have no bound where the
    encounter frequency is 0. Frequencies of 0, infinity, or without a coefficient are left out, and said.

    Raises RaoError when xarray is not installed, the file lacks what is needed, or has implausible figures.
    """
    path = Path(path)
    database = _read(path)
    omega = database.omega
    if frequencies is None:
        frequencies = np.interp(np.arange(4 * omega.size - 3) / 4.0, np.arange(omega.size), omega)
    fine = np.asarray(frequencies, dtype=float)
    if fine.min() < omega[0] - 1e-9 or fine.max() > omega[-1] + 1e-9:
        raise RaoError(f"{path}: has frequencies {omega[0]:g} to {omega[-1]:g} rad/s: the table must lie within")
    force = between(omega, database.excitation.swapaxes(1, 2), fine).swapaxes(1, 2)
    response = np.array(
        [_motions(fine, omega, database.heading, database.coefficients, force, speed, roll_damping) for speed in speeds]
    )
    heading = database.heading
    if database.is_mirrored:
        order = np.argsort(np.mod(-heading, 2.0 * math.pi))
        heading, response = np.mod(-heading, 2.0 * math.pi)[order], response[:, order] * MIRROR[:, None]
    try:
        table = ResponseTable(np.array(speeds, dtype=float), heading, fine, response, database.notes)
    except RaoError as error:
        raise RaoError(f"{path}: {error}") from error
    return judged(path, table, accept=accept_implausible)


def _read(path: Path) -> _Database:
    dataset = _open_dataset(path)
    notes: list[str] = []
    try:
        dataset = _in_headings(_over_omega(path, dataset), notes)
        _refuse_bodies(path, dataset)
        order = [_dof_label(dataset, name) for name in DEGREES_OF_FREEDOM]
        radiation = {"radiating_dof": order, "influenced_dof": order}
        grid = ("omega", "influenced_dof", "radiating_dof")
        added_mass, damping = (
            _one_case(path, dataset[name].sel(radiation)).transpose(*grid).to_numpy()
            for name in ("added_mass", "radiation_damping")
        )
        inertia, stiffness = (
            _one_case(path, dataset[name].sel(radiation)).transpose(*grid[1:]).to_numpy()
            for name in ("inertia_matrix", "hydrostatic_stiffness")
        )
        excitation = _excitation(path, dataset, order)
        omega = dataset["omega"].to_numpy().astype(float)
        heading = dataset["wave_direction"].to_numpy().astype(float)
    except (KeyError, ValueError) as error:
        if isinstance(error, RaoError):
            raise
        raise RaoError(f"{path}: is not a complete Capytaine database: {str(error).splitlines()[0]}") from error
    if not (np.isfinite(inertia).all() and np.isfinite(stiffness).all()):
        raise RaoError(f"{path}: inertia or hydrostatic stiffness is not finite")
    good = np.isfinite(omega) & (omega > 0.0) & np.isfinite(excitation).all(axis=(0, 2))
    good &= np.isfinite(added_mass).all(axis=(1, 2)) & np.isfinite(damping).all(axis=(1, 2))
    if not good.all():
        left_out = ", ".join(f"{value:g}" for value in omega[~good])
        notes.append(f"frequencies {left_out} rad/s left out: coefficients there are not finite")
    if good.sum() < 4:
        raise RaoError(f"{path}: has {int(good.sum())} frequencies with finite coefficients: at least 4 are needed")
    return _Database(
        omega[good],
        heading,
        (added_mass[good], damping[good], inertia, stiffness),
        excitation[:, good],
        bool(heading[-1] > math.pi + _SAME and not ((heading > _SAME) & (heading < math.pi - _SAME)).any()),
        tuple(f"{path}: {note}" for note in notes),
    )


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
    except Exception as error:  # the backends of xarray raise what they like
        first = (str(error) or type(error).__name__).splitlines()[0]
        raise RaoError(f"{path}: cannot be read as NetCDF: {first}") from error
    for name in ("radiating_dof", "influenced_dof", "complex"):
        if name in loaded.coords:
            labels = [label.decode() if isinstance(label, bytes) else str(label) for label in loaded[name].to_numpy()]
            loaded = loaded.assign_coords({name: labels})
    return loaded


def _over_omega(path: Path, dataset: Any) -> Any:
    """Return a database over rising omega, whatever its frequencies were over."""
    axis = next((name for name in dataset["added_mass"].dims if name in (*_OMEGA_OF, "wavenumber", "wavelength")), None)
    if axis is None:
        raise KeyError(f"frequencies (its dimensions are {', '.join(dataset['added_mass'].dims)})")
    if "omega" in dataset.coords and dataset["omega"].dims == (axis,):
        omega = dataset["omega"].to_numpy().astype(float)
    elif axis in _OMEGA_OF:
        with np.errstate(divide="ignore"):
            omega = _OMEGA_OF[axis](dataset[axis].to_numpy().astype(float))
    else:
        raise RaoError(f"{path}: is over {axis} and does not say omega: add omega [rad/s] as a coordinate")
    if axis != "omega":
        dataset = dataset.drop_vars("omega", errors="ignore").rename({axis: "omega"})
    dataset = dataset.assign_coords(omega=omega)
    return dataset.isel(omega=np.unique(omega, return_index=True)[1])


def _in_headings(dataset: Any, notes: list[str]) -> Any:
    """Return a database whose headings rise from 0 to below 2 pi, each once; what was changed goes into the notes."""
    given = np.atleast_1d(dataset["wave_direction"].to_numpy().astype(float))
    if "wave_direction" not in dataset.dims:
        dataset = dataset.expand_dims("wave_direction")
    heading = given
    if np.abs(given).max(initial=0.0) > 2.0 * math.pi + 0.1:
        heading = np.radians(given)
        notes.append(f"headings {given.min():g} to {given.max():g} taken as degrees")
    if heading.min() < -_SAME or heading.max() > 2.0 * math.pi - _SAME:
        notes.append("headings taken from 0 to 2 pi, each once")
    heading = np.round(np.mod(heading + 0.5 * _SAME, 2.0 * math.pi) - 0.5 * _SAME, 12)
    _, first = np.unique(np.round(heading / _SAME), return_index=True)
    return dataset.assign_coords(wave_direction=heading).isel(wave_direction=first)


def _one_case(path: Path, values: Any) -> Any:
    """Return an array without axes that hold one entry; raise RaoError for another axis with several."""
    for axis in set(values.dims) - _AXES:
        if values.sizes[axis] > 1:
            raise RaoError(f"{path}: has {values.sizes[axis]} entries along {axis}: keep one (dataset.isel({axis}=0))")
        values = values.isel({axis: 0})
    return values


def _refuse_bodies(path: Path, dataset: Any) -> None:
    """Raise RaoError for a database of several bodies, whose degrees of freedom are BODY__NAME each."""
    labels = [str(label).partition("__") for label in dataset["influenced_dof"].to_numpy()]
    bodies = dict.fromkeys(body for body, mark, _ in labels if mark)
    if bodies:
        raise RaoError(
            f"{path}: holds the bodies {', '.join(bodies)}, which move one another: compute the vessel alone, or keep "
            "its rows where the others stand still, with labels without the body"
        )


def _dof_label(dataset: Any, name: str) -> str:
    """Return the database's label of the degree of freedom `name`, in capitals or not."""
    labels = [str(label) for label in dataset["influenced_dof"].to_numpy()]
    for label in labels:
        if label.lower() == name:
            return label
    raise KeyError(f"degree of freedom {name} (found {', '.join(labels)})")


def _excitation(path: Path, dataset: Any, order: Sequence[str]) -> ComplexArray:
    """Return the excitation force (heading, omega, 6) in convention e^{+i omega t}; Capytaine's is e^{-i omega t}."""
    force = dataset["Froude_Krylov_force"] + dataset["diffraction_force"]
    force = _one_case(path, force.sel(influenced_dof=list(order))).transpose(
        "complex", "wave_direction", "omega", "influenced_dof"
    )
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
    mass_at = scipy.interpolate.CubicSpline(omega, added_mass, axis=0)
    damping_at = scipy.interpolate.CubicSpline(omega, damping, axis=0)
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
