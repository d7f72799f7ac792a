"""The parameter set of the envelope as a node of its own: nominal winch, cable and unit, and its margins."""

from __future__ import annotations

from dataclasses import dataclass

from cable_sim_node.parameters import CableParameters
from cable_sim_node.unit_parameters import UnitParameters
from heave_node.numerics.constants import SEAWATER_DENSITY, STANDARD_GRAVITY
from heave_node.parameters import group, parameter

from winch_controller_node.interface.sensors import MruModelParameters
from winch_controller_node.parameters.crane import CraneModelParameters
from winch_controller_node.parameters.envelope import EnvelopeParameters
from winch_controller_node.parameters.laws import (
    LimitParameters,
    ModeParameters,
    MoveParameters,
    OperatorParameters,
    TensionLawParameters,
)
from winch_controller_node.parameters.model import (
    CableModelParameters,
    SeaModelParameters,
    VesselModelParameters,
    WinchModelParameters,
)


@dataclass(frozen=True)
class WinchEnvelopeParameters:
    """The envelope between any controller and any winch. Groups mean what they mean in `winch_controller`."""

    length: float = parameter(
        300.0, unit="m", minimum=0.01, maximum=20_000.0, description="Unstretched cable length at payout 0."
    )
    water_density: float = parameter(
        SEAWATER_DENSITY, unit="kg/m^3", minimum=0.0, maximum=2000.0, description="Density of the water."
    )
    gravity: float = parameter(
        STANDARD_GRAVITY, unit="m/s^2", minimum=0.1, maximum=100.0, description="Acceleration of gravity."
    )
    boom_tip_height: float = parameter(
        0.0, unit="m", minimum=-100.0, maximum=200.0, description="Mean height of the boom tip above still water."
    )
    envelope: EnvelopeParameters = group(EnvelopeParameters)
    winch: WinchModelParameters = group(WinchModelParameters)
    cable: CableParameters = group(CableParameters)
    unit: UnitParameters = group(UnitParameters)
    cable_model: CableModelParameters = group(CableModelParameters)
    sea: SeaModelParameters = group(SeaModelParameters)
    vessel: VesselModelParameters = group(VesselModelParameters)
    crane: CraneModelParameters = group(CraneModelParameters)
    mru: MruModelParameters = group(MruModelParameters)
    limits: LimitParameters = group(LimitParameters)
    modes: ModeParameters = group(ModeParameters)
    tension: TensionLawParameters = group(TensionLawParameters)
    move: MoveParameters = group(MoveParameters)
    operator: OperatorParameters = group(OperatorParameters)
