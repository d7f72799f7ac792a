"""The two systems with published particulars and peer numbers on which the plant is judged."""

from __future__ import annotations

from heave_node.constants import SEAWATER_DENSITY, STANDARD_GRAVITY

from cable_sim_node.parameters import CableParameters, CableSimParameters, SolverParameters, UnitParameters


def s300(
    segments: int = 20,
    current: tuple[float, float] = (0.0, 0.0),
    *,
    time_step: float = 0.05,
    spectral_radius: float = 0.8,
) -> CableSimParameters:
    """Return the 300 m system of thesis section 5.7 with `current` [m/s] along x and y."""
    return CableSimParameters(
        length=300.0,
        segments=segments,
        current=current,
        solver=SolverParameters(time_step=time_step, spectral_radius=spectral_radius),
    )


def s900(segments: int = 100, *, time_step: float = 0.05, spectral_radius: float = 0.8) -> CableSimParameters:
    """Return the 900 m system of thesis section 6.2.6: 54 N/m and 50 kN in water, effective mass 125 t.

    The thesis gives no volume and no added mass apart from the effective mass, so all of it is mass here.
    """
    mass, weight = 125e3, 50e3
    return CableSimParameters(
        length=900.0,
        segments=segments,
        cable=CableParameters(
            # 54 N/m in water with 7.2 kg/m: this diameter displaces the difference, drag stays on 0.047 m
            displaced_diameter=0.045868,
            mass_per_length=7.2,
            axial_stiffness=1.57706e7,
            tangential_drag=0.025,
        ),
        unit=UnitParameters(
            mass=mass,
            volume=(mass - weight / STANDARD_GRAVITY) / SEAWATER_DENSITY,
            added_mass=(0.0, 0.0, 0.0),
            drag_coefficient=(1.0, 1.0, 1.0),
            drag_area=(1.0, 1.0, 1.0),
        ),
        solver=SolverParameters(time_step=time_step, spectral_radius=spectral_radius),
    )
