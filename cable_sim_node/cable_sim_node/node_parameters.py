"""Parameters of the node `cable_sim`: those of the plant, and of the sensors on it."""

from __future__ import annotations

from dataclasses import dataclass

from heave_node.parameters import group, parameter

from cable_sim_node.parameters import CableSimParameters
from cable_sim_node.sensors.instruments import SensorsParameters


@dataclass(frozen=True)
class LinearModelParameters:
    """The two-state plant of thesis Eq. 6.2: a x'' + b x' + x = x_0 - u."""

    inertia: float = parameter(0.8959, "s^2", 1e-6, 1e6, "a of thesis Eq. 6.2.")
    damping: float = parameter(0.1658, "s", 0.0, 1e6, "b of thesis Eq. 6.2.")


@dataclass(frozen=True)
class CableSimNodeParameters(CableSimParameters):
    """Everything `cable_sim` needs: the plant's parameters under their own names, and the sensors under `sensors`."""

    model: str = parameter("lumped_mass",
        description="lumped_mass (thesis chapter 5), or the linear two-state plant of thesis Eq. 6.2.",
        choices=("lumped_mass", "linear"))  # fmt: skip
    linear: LinearModelParameters = group(LinearModelParameters)
    boom_tip_height: float = parameter(0.0, "m", -100.0, 200.0,
        "Height of the mean boom tip above still water at the start.")  # fmt: skip
    shadow_follows_programme: bool = parameter(False,
        description="The winch of the uncompensated plant follows the depth programme; false: it stays locked.",
    )  # fmt: skip
    sensors: SensorsParameters = group(SensorsParameters)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.model == "linear" and self.wave.source != "none":
            raise ValueError(f"model = linear has no water: it needs wave.source = none, not {self.wave.source}")
        unit = self.unit
        stated = {
            "unit.oscillation": unit.oscillation.kc,
            "cable.loss_factor": self.cable.loss_factor,
        }
        without_effect = [name for name, value in stated.items() if value]
        if self.model == "linear" and without_effect:
            raise ValueError(f"model = linear knows no {without_effect[0]}: leave it out, or take model = lumped_mass")
