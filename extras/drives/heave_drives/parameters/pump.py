"""Parameters of the pump-controlled hydraulic drive; `pump_controlled` says what they mean."""

from __future__ import annotations

from dataclasses import dataclass

from heave_node.parameters import Checked, group, parameter

from heave_drives.parameters.motion import FrictionParameters, MotionParameters


@dataclass(frozen=True)
class PumpControlledParameters(Checked):
    """Pump, motors, drum and speed loop of a pump-controlled hydraulic winch. The defaults are a 10 t winch."""

    friction: FrictionParameters = group(FrictionParameters, coulomb=1e3, slip_speed=0.05, viscous=2e3)
    drum_radius: float = parameter(0.5, "m", 0.01, 20.0, "Radius from the drum's axis to the rope.")
    drum_inertia: float = parameter(500.0, "kg m^2", 1e-6, 1e7, "Inertia about the drum's axis, motors included.")
    load_mass: float = 0.0  # mass moving rigidly with the rope that the tension does not include [kg]
    gear_ratio: float = parameter(50.0, "", 0.1, 1e4, "K: motor turns per drum turn.")
    motor_displacement: float = parameter(5e-5, "m^3/rad", 1e-9, 1.0,
        "D_m: displacement of all motors together, at full stroke.")  # fmt: skip
    motor_minimum: float = parameter(1.0, "", 0.05, 1.0,
        "Smallest displacement as a fraction of full displacement; 1 is a fixed-displacement motor.")  # fmt: skip
    motor_time_constant: float = 0.1  # time constant of the motors' displacement [s]
    motor_efficiency: float = parameter(0.92, "", 0.05, 1.0, "eta: mechanical efficiency of motors and gear.")
    is_passive: bool = True  # losses from efficiency act as friction; false: as a constant factor, as published
    pump_displacement: float = parameter(5e-5, "m^3/rad", 1e-9, 1.0,
        "D_p: displacement of all pumps together, at full swash.")  # fmt: skip
    pump_speed: float = parameter(150.0, "rad/s", 0.1, 1e4, "w_p: speed of the pump shaft.")
    swash_time_constant: float = 0.05  # T_p: time constant of the swash plate [s]
    swash_input_limit: float = 5.0  # largest input of the swash servo, as a fraction of full swash [-]
    bulk_modulus: float = 1.2e9  # k_b: bulk modulus of the fluid [Pa]
    line_volume: float = 2e-3  # V_c: volume of both lines together [m^3]
    leakage: float = parameter(4e-11, "m^3/s/Pa", 0.0, 1e-6, "c: leakage of pump and motors per unit pressure.")
    relief_pressure: float = parameter(35e6, "Pa", 0.0, 1e9,
        "Pressure at which the relief valves open; 0: no relief valves.")  # fmt: skip
    power_limit: float = parameter(0.0, "W", 0.0, 1e9, "Largest hydraulic power of the pump; 0: no limit.")
    gain: float = parameter(1.0, "", 0.0, 1e3, "k: gain of the speed loop, from speed error over v_full to swash.")
    integral_time: float = parameter(0.3, "s", 1e-3, 1e3, "Integral time of the speed loop; unused if its gain is 0.")

    @property
    def full_speed(self) -> float:
        """Rope speed at full swash and full motor displacement [m/s]."""
        return self.pump_displacement * self.pump_speed / self.area

    @property
    def area(self) -> float:
        """A: flow of the motors per rope speed, force per pressure [m^2]."""
        return self.motor_displacement * self.gear_ratio / self.drum_radius

    @property
    def mass(self) -> float:
        """M: mass that the rope feels [kg]."""
        return self.drum_inertia / self.drum_radius**2 + self.load_mass


@dataclass(frozen=True)
class PumpDriveParameters(PumpControlledParameters):
    """A pump-controlled drive on its own: with what its motion is kept within, which in a winch is the winch's."""

    motion: MotionParameters = group(MotionParameters, speed_limit=1.5)
