"""The parameter set of the winch controller. It is above the laws, each of which brings its own group."""

from __future__ import annotations

from dataclasses import dataclass, make_dataclass
from typing import TYPE_CHECKING

from cable_sim_node.parameters import CableParameters
from cable_sim_node.unit_parameters import UnitParameters
from heave_node.extras import extra_of, extra_parts, missing_extra
from heave_node.numerics.constants import SEAWATER_DENSITY, STANDARD_GRAVITY
from heave_node.parameters import ParameterError, group, parameter

from winch_controller_node.interface.sensors import KNOWN_SENSORS, SensorsModelParameters
from winch_controller_node.laws.registry import LAWS, PLACE, load_law, parameters_of_place
from winch_controller_node.parameters.envelope import EnvelopeParameters
from winch_controller_node.parameters.laws import (
    AlarmParameters,
    EntryParameters,
    GuardParameters,
    HealthParameters,
    LagParameters,
    LimitParameters,
    ModeParameters,
    MoveParameters,
    OperatorParameters,
    ProgrammeParameters,
    TensionLawParameters,
)
from winch_controller_node.parameters.model import (
    CableModelParameters,
    CraneModelParameters,
    EstimatorParameters,
    SeaModelParameters,
    VesselModelParameters,
    WeightParameters,
    WinchModelParameters,
)

MOTION_SOURCES = "heave.motion_sources"
"""Group of entry points that stand in front of the controller, see `in_front`."""
CRANE = "crane"
"""Name of that which reads `crane/pose`."""

if TYPE_CHECKING:

    class LawGroups:
        """One group for each law that has parameters of its own; only the law itself reads it."""

else:
    LawGroups = make_dataclass(
        "LawGroups",
        [
            (law.name, law.parameters_type, group(law.parameters_type))
            for law in LAWS.values()
            if law.parameters_type is not None
        ],
        frozen=True,
    )


@dataclass(frozen=True)
class WinchControllerParameters(LawGroups):
    """The assumed plant, winch, sea and sensors, and how the controller holds the unit still."""

    law: str = parameter(
        "mpc",
        unit="",
        choices=tuple(LAWS),
        also=PLACE,
        also_words="MODULE:CLASS or FILE.py:CLASS of a law of your own",
        description=f"The control law. {'; '.join(f'{law.name}: {law.summary}' for law in LAWS.values())}.",
    )
    law_parameters: tuple[str, ...] = parameter(
        (), unit="", description="Parameters of a law named by file or module, each NAME=VALUE."
    )
    factor: float = parameter(1.0, "", 0.0, 1.0,
        "Largest gain (authority): fraction of the boom tip's motion that is compensated.", is_live=True)  # fmt: skip
    length: float = parameter(300.0, "m", 0.01, 20_000.0, "Unstretched cable length at payout 0.")
    water_density: float = parameter(SEAWATER_DENSITY, "kg/m^3", 0.0, 2000.0, "Density of the water.")
    gravity: float = parameter(STANDARD_GRAVITY, "m/s^2", 0.1, 100.0, "Acceleration of gravity.")
    boom_tip_height: float = parameter(0.0, "m", -100.0, 200.0,
        "Mean height of the boom tip above still water; determines depth and immersion of the load.")  # fmt: skip
    cable: CableParameters = group(CableParameters)
    unit: UnitParameters = group(UnitParameters)
    cable_model: CableModelParameters = group(CableModelParameters)
    winch: WinchModelParameters = group(WinchModelParameters)
    sea: SeaModelParameters = group(SeaModelParameters)
    vessel: VesselModelParameters = group(VesselModelParameters)
    crane: CraneModelParameters = group(CraneModelParameters)
    sensors: SensorsModelParameters = group(SensorsModelParameters)
    weights: WeightParameters = group(WeightParameters)
    estimator: EstimatorParameters = group(EstimatorParameters)
    limits: LimitParameters = group(LimitParameters)
    guard: GuardParameters = group(GuardParameters)
    lag: LagParameters = group(LagParameters)
    modes: ModeParameters = group(ModeParameters)
    tension: TensionLawParameters = group(TensionLawParameters)
    envelope: EnvelopeParameters = group(EnvelopeParameters)
    alarms: AlarmParameters = group(AlarmParameters)
    entry: EntryParameters = group(EntryParameters)
    move: MoveParameters = group(MoveParameters)
    operator: OperatorParameters = group(OperatorParameters)
    programme: ProgrammeParameters = group(ProgrammeParameters)
    health: HealthParameters = group(HealthParameters)
    kpi_window: float = 60.0  # length of the rolling window of controller/kpi [s]

    @property
    def identifies_winch(self) -> bool:
        """Whether the winch is identified while the loop runs: only a speed servo is."""
        return self.lag.adaptation and self.winch.law != "first_order"

    def __post_init__(self) -> None:
        if self.sea.filter_states % 2:
            raise ParameterError(f"sea.filter_states must be even, got {self.sea.filter_states}")
        unknown = set(self.sensors.use) - set(KNOWN_SENSORS)
        if unknown:
            raise ParameterError(
                f"sensors.use: unknown sensor {', '.join(sorted(unknown))}; known: {', '.join(KNOWN_SENSORS)}"
            )


def load_chosen_parts(parameters: WinchControllerParameters) -> None:
    """Load the law that a user has chosen in these `parameters`, check what was given to it, and look for the crane's.

    Raises ParameterError, in one line, where there is no such law, it does not take its parameters, or what reads the
    pose of a crane is not installed.
    """
    if parameters.crane.is_fitted and CRANE not in extra_parts(MOTION_SOURCES):
        raise ParameterError(str(missing_extra("system.crane", extra_of(MOTION_SOURCES, CRANE))))
    law = load_law(parameters.law)
    if ":" in parameters.law:
        parameters_of_place(law, parameters.law_parameters)


@dataclass(frozen=True)
class WinchAdviserParameters:
    """The adviser has none of its own: its nominal, the controller's parameters, comes with the observations."""
