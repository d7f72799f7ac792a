"""The parameter set of the envelope as a node of its own: nominal winch, cable and unit, and its margins."""

from __future__ import annotations

from dataclasses import dataclass

from cable_sim_node.parameters import CableParameters
from cable_sim_node.unit_parameters import UnitParameters
from heave_node.numerics.constants import SEAWATER_DENSITY, STANDARD_GRAVITY
from heave_node.parameters import group, parameter

from winch_controller_node.interface.sensors import MruModelParameters
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

    length: float = parameter(300.0, "m", 0.01, 20_000.0, "Unstretched cable length at payout 0.")
    water_density: float = parameter(SEAWATER_DENSITY, "kg/m^3", 0.0, 2000.0, "Density of the water.")
    gravity: float = parameter(STANDARD_GRAVITY, "m/s^2", 0.1, 100.0, "Acceleration of gravity.")
    boom_tip_height: float = parameter(0.0, "m", -100.0, 200.0, "Mean height of the boom tip above still water.")
    envelope: EnvelopeParameters = group(EnvelopeParameters)
    winch: WinchModelParameters = group(WinchModelParameters)
    cable: CableParameters = group(CableParameters)
    unit: UnitParameters = group(UnitParameters)
    cable_model: CableModelParameters = group(CableModelParameters)
    sea: SeaModelParameters = group(SeaModelParameters)
    vessel: VesselModelParameters = group(VesselModelParameters)
    mru: MruModelParameters = group(MruModelParameters)
    limits: LimitParameters = group(LimitParameters)
    modes: ModeParameters = group(ModeParameters)
    tension: TensionLawParameters = group(TensionLawParameters)
    move: MoveParameters = group(MoveParameters)
    operator: OperatorParameters = group(OperatorParameters)
