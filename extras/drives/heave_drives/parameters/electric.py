"""Parameters of the electric winch drive; `electric` says what they mean."""

from __future__ import annotations

from dataclasses import dataclass

from heave_node.parameters import Checked, check_ranges, group, parameter

from heave_drives.parameters.motion import FrictionParameters, MotionParameters
from heave_drives.parameters.spool import SpoolParameters


@dataclass(frozen=True)
class ElectricParameters(Checked):
    """Motor, gear, drum and speed loop of an electric winch. The defaults are a 20 t winch of 400 kW."""

    friction: FrictionParameters = group(FrictionParameters, coulomb=1e3, load=0.02, viscous=500.0)
    spool: SpoolParameters = group(SpoolParameters)
    drum_inertia: float = parameter(1000.0, "kg m^2", 0.0, 1e7, "Inertia of drum and gear about the drum's axis.")
    motor_inertia: float = parameter(5.0, "kg m^2", 1e-6, 1e5, "Inertia of all motors about their own axes.")
    gear_ratio: float = parameter(40.0, "", 0.1, 1e4, "Motor turns per drum turn.")
    load_mass: float = 0.0  # mass moving rigidly with the rope that the tension does not include [kg]
    torque_limit: float = parameter(4000.0, "N m", 1e-3, 1e8, "Largest torque of all motors together.")
    motoring_power_limit: float = parameter(400e3, "W", 1.0, 1e9, "Largest motoring shaft power.")
    regeneration_power_limit: float = parameter(400e3, "W", 1.0, 1e9, "Largest braking shaft power.")
    torque_time_constant: float = 0.005  # time constant of the torque (current loop, field) [s]
    copper_loss: float = parameter(10e3, "W", 0.0, 1e8, "Copper loss at torque_limit; proportional to torque^2.")
    reference_time: float = 0.05  # time constant with which the speed reference follows the set-point [s]
    bandwidth: float = parameter(20.0, "rad/s", 0.1, 1000.0, "Gain of the speed loop, divided by mass.")
    integral_time: float = parameter(0.3, "s", 1e-3, 1000.0, "Integral time of the speed loop.")
    tension_feed_forward: float = 0.0  # fraction of the measured tension that is fed forward [-]

    @property
    def inertia(self) -> float:
        """Inertia at the drum, motors included [kg m^2]."""
        return self.drum_inertia + self.gear_ratio**2 * self.motor_inertia


@dataclass(frozen=True)
class ElectricDriveParameters(ElectricParameters):
    """An electric drive on its own: with what its motion is kept within, which in a winch is the winch's."""

    motion: MotionParameters = group(MotionParameters)
    acceleration_limit: float = parameter(1.5, "m/s^2", 1e-3, 1e6, "Largest acceleration of the speed reference.")

    def __post_init__(self) -> None:
        check_ranges(self)
        self.spool.check_rope(self.motion.payout_maximum)
