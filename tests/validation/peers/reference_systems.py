"""The two systems with published particulars and peer numbers on which plant and controller are judged."""

from __future__ import annotations

from collections.abc import Mapping

from cable_sim_node.parameters import CableParameters, CableSimParameters, SolverParameters
from cable_sim_node.unit_parameters import UnitParameters
from heave_node.numerics.constants import SEAWATER_DENSITY, STANDARD_GRAVITY

DEEP_900: Mapping[str, object] = {
    "length": 900.0,
    "cable.diameter": 0.047,
    # 54 N/m in water with 7.2 kg/m: this diameter displaces the difference, drag stays on 0.047 m
    "cable.displaced_diameter": 0.045868,
    "cable.mass_per_length": 7.2,
    "cable.axial_stiffness": 15770645.9,
    "cable.tangential_drag": 0.025,
    "unit.mass": 65000.0,
    "unit.volume": 58.4404,
    "unit.added_mass": [60000.0] * 3,
    "unit.drag_coefficient": [1.0] * 3,
    "unit.drag_area": [1.0] * 3,
}
"""Parameters that the 900 m scenarios give to plant and controller: `s900`, its effective mass parted between unit and
water.
"""


def s300(
    segments: int = 20,
    current: tuple[float, float] = (0.0, 0.0),
    *,
    time_step: float = 0.05,
    spectral_radius: float = 0.8,
) -> CableSimParameters:
    """Return the 300 m system of thesis section 5.7; water surrounds all of it, as in the peers' runs.

    Parameters
    ----------
    segments : of the line
    current : along x and y [m/s]
    time_step, spectral_radius : of the solver
    """
    return CableSimParameters(
        length=300.0,
        segments=segments,
        current=current,
        surface=False,
        solver=SolverParameters(time_step=time_step, spectral_radius=spectral_radius),
    )


def s900(segments: int = 100, *, time_step: float = 0.05, spectral_radius: float = 0.8) -> CableSimParameters:
    """Return the 900 m system of thesis section 6.2.6: 54 N/m and 50 kN in water, effective mass 125 t.

    The thesis gives no volume and no added mass apart from the effective mass, so all of it is mass here. Water
    surrounds all of it, as in the peers' runs.

    Parameters
    ----------
    segments : of the line
    time_step, spectral_radius : of the solver
    """
    mass, weight = 125e3, 50e3
    return CableSimParameters(
        length=900.0,
        segments=segments,
        surface=False,
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
