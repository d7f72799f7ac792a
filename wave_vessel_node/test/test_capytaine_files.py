"""Databases of Capytaine as people write them: over omega, period or frequency, infinities, headings of all forms."""

import numpy as np
import pytest
from wave_vessel_node.vessel.capytaine_files import read_capytaine
from wave_vessel_node.vessel.rao import MIRROR, RaoError, encounter_frequency

xarray = pytest.importorskip("xarray")
pytest.importorskip("netCDF4")

HEAVE = 2


def capytaine_database(tmp_path, drop=(), change=None):
    """Write a database of a heaving buoy as Capytaine lays it out: mass 2, added mass 1, damping 0.6, stiffness 4,
    force 3; `change` is a function of the dataset before it is written."""
    dofs = ["Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw"]
    omega, direction = np.linspace(0.3, 3.0, 28), np.linspace(0.0, np.pi, 5)
    identity = np.eye(6)
    grid = ("omega", "influenced_dof", "radiating_dof")
    force = np.zeros((2, omega.size, direction.size, 6))
    force[0, :, :, 2], force[1, :, :, 2] = 2.0, 0.5
    axes = ("complex", "omega", "wave_direction", "influenced_dof")
    variables = {
        "added_mass": (grid, np.tile(1.0 * identity, (omega.size, 1, 1))),
        "radiation_damping": (grid, np.tile(0.6 * identity, (omega.size, 1, 1))),
        "inertia_matrix": (grid[1:], 2.0 * identity),
        "hydrostatic_stiffness": (grid[1:], 4.0 * identity),
        "Froude_Krylov_force": (axes, force),
        "diffraction_force": (axes, 0.5 * force),
    }
    coordinates = {
        "omega": omega,
        "wave_direction": direction,
        "influenced_dof": dofs,
        "radiating_dof": dofs,
        "complex": ["re", "im"],
    }
    dataset = xarray.Dataset({name: value for name, value in variables.items() if name not in drop}, coordinates)
    dataset = dataset if change is None else change(dataset)
    path = tmp_path / "buoy.nc"
    dataset.to_netcdf(path, engine="netcdf4")
    return path


def test_a_capytaine_database_gives_the_motions_of_the_equation_of_motion(tmp_path):
    table = read_capytaine(capytaine_database(tmp_path), speeds=(0.0, 2.0))
    omega = table.frequency
    # Capytaine's phases are e^(-i omega t): the force 3 + 0.75 i is 3 - 0.75 i here
    expected = (3.0 - 0.75j) / (4.0 - 3.0 * omega**2 + 0.6j * omega)
    np.testing.assert_allclose(table.response[0, 2, HEAVE], expected, rtol=1e-10)
    encounter = encounter_frequency(omega, np.pi, 2.0)
    moving = (3.0 - 0.75j) / (4.0 - 3.0 * encounter**2 + 0.6j * encounter)
    np.testing.assert_allclose(table.response[1, 4, HEAVE], moving, rtol=1e-10)


def test_an_incomplete_or_foreign_database_is_refused(tmp_path):
    with pytest.raises(RaoError, match="not a complete Capytaine database"):
        read_capytaine(capytaine_database(tmp_path, drop=("added_mass",)))
    (tmp_path / "x.nc").write_bytes(b"CDF no")
    with pytest.raises(RaoError, match="cannot be read as NetCDF"):
        read_capytaine(tmp_path / "x.nc")


def over(name, values):
    """Return a change of a database: its frequencies are over another coordinate, the highest omega last or first."""
    return lambda data: data.assign_coords({name: ("omega", values(data["omega"].to_numpy()))}).swap_dims(omega=name)


@pytest.mark.parametrize(
    "change",
    [
        over("period", lambda omega: 2.0 * np.pi / omega),
        lambda data: over("period", lambda omega: 2.0 * np.pi / omega)(data).drop_vars("omega").sortby("period"),
        lambda data: over("freq", lambda omega: omega / 2.0 / np.pi)(data).drop_vars("omega"),
        over("wavenumber", lambda omega: omega**2 / 9.81),
        lambda data: data.expand_dims(water_depth=[np.inf]),
        lambda data: data.isel(omega=slice(None, None, -1)),
    ],
)
def test_a_database_is_the_same_over_whatever_its_frequencies_are(tmp_path, change):
    plain = read_capytaine(capytaine_database(tmp_path))
    other = read_capytaine(capytaine_database(tmp_path, change=change))
    np.testing.assert_allclose(other.frequency, plain.frequency, rtol=1e-12)
    np.testing.assert_allclose(other.response, plain.response, rtol=1e-9)
    assert other.warnings == ()


def with_limits(data):
    """Add the frequencies 0 and infinity, at which there is no excitation."""
    limits = data.isel(omega=[0, 0]).assign_coords(omega=[0.0, np.inf])
    for name in ("Froude_Krylov_force", "diffraction_force"):
        limits[name] = limits[name] * np.nan
    return xarray.concat([limits.isel(omega=[1]), data, limits.isel(omega=[0])], dim="omega", data_vars="minimal")


def with_holes(data):
    """Make the added mass at the first two frequencies NaN."""
    return data.assign(added_mass=data["added_mass"].where(data["omega"] > data["omega"][1]))


def test_frequencies_without_coefficients_are_left_out_and_named(tmp_path):
    plain = read_capytaine(capytaine_database(tmp_path))
    limited = read_capytaine(capytaine_database(tmp_path, change=with_limits))
    np.testing.assert_array_equal(limited.response, plain.response)
    assert any("frequencies 0, inf rad/s left out" in warning for warning in limited.warnings)
    holed = read_capytaine(capytaine_database(tmp_path, change=with_holes))
    assert holed.frequency[0] == pytest.approx(0.5)
    assert any("frequencies 0.3, 0.4 rad/s left out" in warning for warning in holed.warnings)


def directed(headings):
    """Return a change of a database: its headings, and forces on heave as 3 - cos(heading), on sway as sin(heading)."""

    def change(data):
        angle = np.radians(headings) if np.abs(headings).max() > 7.0 else np.asarray(headings)
        data = data.isel(wave_direction=np.zeros(len(headings), int)).assign_coords(wave_direction=np.asarray(headings))
        for name in ("Froude_Krylov_force", "diffraction_force"):
            force = np.zeros(data[name].shape)
            force[0, :, :, HEAVE] = (3.0 - np.cos(angle)) / 3.0
            force[0, :, :, 1] = np.sin(angle)
            data[name] = (data[name].dims, force)
        return data

    return change


@pytest.mark.parametrize(
    "headings",
    [
        np.linspace(0.0, np.pi, 9),
        np.linspace(0.0, 2.0 * np.pi, 17),
        np.linspace(-np.pi, np.pi, 17),
        np.linspace(-np.pi, 0.0, 9),
        np.linspace(0.0, 180.0, 9),
        np.linspace(0.0, 360.0, 17),
        np.linspace(-180.0, 180.0, 17),
        np.linspace(0.0, 2.0 * np.pi, 17)[:-1][::-1],
    ],
)
def test_headings_of_every_form_give_one_table(tmp_path, headings):
    table = read_capytaine(capytaine_database(tmp_path, change=directed(headings)))
    half = read_capytaine(capytaine_database(tmp_path, change=directed(np.linspace(0.0, np.pi, 9))))
    omega = half.frequency[::9]
    for angle in (0.0, 0.7, 2.4, np.pi, 4.0, 5.5):
        # a spline of nine points in half a turn, with or without its mirror image
        np.testing.assert_allclose(table.at(omega, angle), half.at(omega, angle), rtol=2e-3, atol=2e-3)
    assert MIRROR[1] == -1.0


def of_two_bodies(data):
    """Return the database as of two bodies side by side, labelled as Capytaine does: BODY__DOF."""

    def labelled(dataset, axis, body):
        return dataset.assign_coords({axis: [f"{body}__{name}" for name in dataset[axis].to_numpy()]})

    for axis in ("influenced_dof", "radiating_dof"):
        pair = [labelled(data, axis, body) for body in ("ship", "barge")]
        data = xarray.concat(pair, axis, data_vars="minimal", coords="minimal", compat="override")
    return data


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda data: data.isel(wave_direction=[2]), "headings must span 0 to pi"),
        (lambda data: data.isel(wave_direction=slice(0, 3)), "these are 0, .* degrees; compute the others"),
        (of_two_bodies, "holds the bodies ship, barge, which move one another"),
        (
            lambda data: xarray.concat([data, data], "water_depth").assign_coords(water_depth=[50.0, 200.0]),
            "along water_depth",
        ),
        (lambda data: data * np.nan, "is not finite"),
        (lambda data: data.isel(omega=slice(0, 3)), "at least 4"),
        (lambda data: data.rename(omega="q"), "not a complete Capytaine database"),
        (lambda data: data.assign(hydrostatic_stiffness=0.001 * data["hydrostatic_stiffness"]), "heave in long waves"),
    ],
)
def test_a_database_that_cannot_be_used_is_refused_in_one_line(tmp_path, change, says):
    with pytest.raises(RaoError, match=says) as refused:
        read_capytaine(capytaine_database(tmp_path, change=change))
    assert "buoy.nc" in str(refused.value)
    assert "\n" not in str(refused.value)
