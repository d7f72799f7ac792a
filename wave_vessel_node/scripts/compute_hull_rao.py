"""Compute the motions of the hull form that ships with the package, with Capytaine (linear potential flow, zero speed).

Writes the hydrodynamic database (Capytaine's NetCDF) and the table of RAOs made from it at several speeds. Needs the
extra `capytaine`. Takes a few minutes:

    cd wave_vessel_node
    python scripts/compute_hull_rao.py --database hull.nc --table wave_vessel_node/data/wigley_90m.csv

Hull form: the modified Wigley form of the seakeeping experiments of Delft (Journee, 1992), the blunt variant, with
length to beam 5: y = (B/2) [(1 - z'^2)(1 - x'^2)(1 + 0.2 x'^2) + z'^2 (1 - z'^8)(1 - x'^2)^4], x' = 2 x / L,
z' = z / T. Scaled to a construction vessel: L = 90 m, B = 18 m, T = 5.625 m.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

import capytaine as cpt
import numpy as np
from heave_node.numerics.constants import SEAWATER_DENSITY, STANDARD_GRAVITY
from wave_vessel_node.vessel.capytaine_files import read_capytaine
from wave_vessel_node.vessel.rao_files import write_rao_csv

LENGTH, BEAM, DRAUGHT = 90.0, 18.0, 5.625
METACENTRIC_HEIGHT = 1.5  # m, transverse
GYRATION = (0.38 * BEAM, 0.25 * LENGTH, 0.25 * LENGTH)  # m, about x, y, z
ROLL_DAMPING = 0.05  # of critical, for what potential flow lacks (bilge keels, friction)
OMEGA = np.concatenate((np.arange(0.15, 0.5, 0.05), np.arange(0.5, 1.3, 0.04), np.arange(1.3, 2.61, 0.1)))
TABLE_OMEGA = np.concatenate(  # the table: fine where roll resonates, at rest and under way
    (np.arange(0.15, 0.4, 0.05), np.arange(0.4, 1.0, 0.0125), np.arange(1.0, 1.3, 0.04), np.arange(1.3, 2.551, 0.1))
)
HEADINGS = np.radians(np.arange(0.0, 181.0, 15.0))
SPEEDS = (0.0, 2.5, 5.0)
DEGREES_OF_FREEDOM = ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")


def say(line: str) -> None:
    """Show how far the work is."""
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


def half_breadth(x: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Return y of the hull at x (forward of midship) and z (0 at the waterline, -DRAUGHT at the keel) [m]."""
    xi, zeta = 2.0 * x / LENGTH, z / DRAUGHT
    wigley = (1.0 - zeta**2) * (1.0 - xi**2) * (1.0 + 0.2 * xi**2)
    return 0.5 * BEAM * (wigley + zeta**2 * (1.0 - zeta**8) * (1.0 - xi**2) ** 4)


def hull_mesh(panels_along: int = 48, panels_down: int = 9) -> cpt.Mesh:
    """Return the wetted hull as panels, cosine-spaced towards ends and keel."""
    x = -0.5 * LENGTH * np.cos(np.linspace(0.0, np.pi, panels_along + 1))
    z = -DRAUGHT * np.sin(np.linspace(0.0, 0.5 * np.pi, panels_down + 1))
    grid_x, grid_z = np.meshgrid(x, z, indexing="ij")
    grid_y = half_breadth(grid_x, grid_z)
    port = np.stack((grid_x, grid_y, grid_z), axis=-1).reshape(-1, 3)
    columns = panels_down + 1
    faces = [
        (i * columns + j, (i + 1) * columns + j, (i + 1) * columns + j + 1, i * columns + j + 1)
        for i in range(panels_along)
        for j in range(panels_down)
    ]
    starboard = port * (1.0, -1.0, 1.0)
    vertices = np.vstack((port, starboard))
    mirrored = [tuple(index + len(port) for index in reversed(face)) for face in faces]
    mesh = cpt.Mesh(vertices=vertices, faces=np.array(faces + mirrored), name="wigley")
    return mesh.heal() if hasattr(mesh, "heal") else mesh


def hull_body() -> cpt.FloatingBody:
    """Return the body with its mass, centre of gravity and degrees of freedom about it."""
    mesh = hull_mesh()
    if mesh.volume < 0.0:
        mesh = mesh.flipped_normals()
    x, w = np.polynomial.legendre.leggauss(60)
    y = half_breadth(0.5 * LENGTH * x, np.zeros_like(x))
    waterplane_inertia = (2.0 / 3.0) * float((w * y**3).sum()) * 0.5 * LENGTH
    buoyancy_height = float(mesh.center_of_buoyancy[2])
    centre = np.array([0.0, 0.0, buoyancy_height + waterplane_inertia / mesh.volume - METACENTRIC_HEIGHT])
    body = cpt.FloatingBody(
        mesh=mesh,
        lid_mesh=mesh.generate_lid(z=-0.01),
        dofs=cpt.rigid_body_dofs(rotation_center=centre),
        center_of_mass=centre,
        name="wigley_90m",
    )
    mass = SEAWATER_DENSITY * mesh.volume
    body.inertia_matrix = body.add_dofs_labels_to_matrix(
        np.diag([mass] * 3 + [mass * radius**2 for radius in GYRATION])
    )
    body.hydrostatic_stiffness = body.compute_hydrostatic_stiffness(rho=SEAWATER_DENSITY, g=STANDARD_GRAVITY)
    say(f"volume {mesh.volume:.1f} m^3, mass {mass / 1e3:.0f} t, centre of gravity {centre[2]:+.2f} m")
    return body


def solve(body: cpt.FloatingBody) -> Any:
    """Return Capytaine's dataset of added mass, damping and excitation."""
    setting = {"body": body, "rho": SEAWATER_DENSITY, "g": STANDARD_GRAVITY, "water_depth": np.inf}
    solver = cpt.BEMSolver()
    results = []
    for omega in OMEGA:
        problems = [cpt.RadiationProblem(omega=omega, radiating_dof=dof, **setting) for dof in body.dofs]
        problems += [cpt.DiffractionProblem(omega=omega, wave_direction=heading, **setting) for heading in HEADINGS]
        results += [solver.solve(problem, keep_details=False) for problem in problems]
        say(f"omega {omega:.2f} rad/s")
    return cpt.assemble_dataset(results)


def write_database(dataset: Any, path: Path) -> None:
    """Write Capytaine's dataset as NetCDF; dimensions that are text become plain text."""
    for name in ("influenced_dof", "radiating_dof", "complex", "space_coordinate"):
        dataset = dataset.assign_coords({name: [str(label) for label in dataset[name].to_numpy()]})
    dataset.to_netcdf(path, engine="netcdf4")


def documentation() -> list[str]:
    """Return the comments of the table: what it holds and where it comes from."""
    return [
        "RAOs of a 90 m construction vessel: modified Wigley hull, computed with Capytaine (linear potential flow) by",
        "wave_vessel_node/scripts/compute_hull_rao.py, where the hull form, its mass and damping are documented.",
        f"L {LENGTH:g} m, B {BEAM:g} m, T {DRAUGHT:g} m, displacement 5209 t, GM {METACENTRIC_HEIGHT:g} m, deep water.",
        "Motions of the centre of gravity (midship, 0.30 m above the waterline) per metre of wave amplitude.",
        "Axes x forward, y to port, z up. Heading: direction the waves travel to (0 following, pi head sea).",
        "omega: wave frequency. Phase: lead over the wave crest at the reference point.",
    ]


def main() -> None:
    """Run the computation."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--database", type=Path, required=True, help="NetCDF to write (or to read, with --from-database)"
    )
    parser.add_argument("--table", type=Path, required=True, help="CSV table of RAOs to write")
    parser.add_argument("--from-database", action="store_true", help="make the table from an existing database")
    arguments = parser.parse_args()
    if not arguments.from_database:
        write_database(cpt.io.xarray.separate_complex_values(solve(hull_body())), arguments.database)
    rao = read_capytaine(arguments.database, speeds=SPEEDS, roll_damping=ROLL_DAMPING, frequencies=TABLE_OMEGA)
    write_rao_csv(arguments.table, rao, comments=documentation())


if __name__ == "__main__":
    main()
