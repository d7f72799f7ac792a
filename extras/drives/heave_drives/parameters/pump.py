"""Parameters of the pump-controlled hydraulic drive; `pump_controlled` says what they mean."""

from __future__ import annotations

from dataclasses import dataclass

from heave_node.parameters import Checked, group, parameter

from heave_drives.parameters.motion import FrictionParameters, MotionParameters


@dataclass(frozen=True)
class PumpControlledParameters(Checked):
    """Pump, motors, drum and speed loop of a pump-controlled hydraulic winch. The defaults are a 10 t winch."""

    friction: FrictionParameters = group(FrictionParameters, coulomb=1e3, slip_speed=0.05, viscous=2e3)
    drum_radius: float = parameter(
        0.5, unit="m", minimum=0.01, maximum=20.0, description="Radius from the drum's axis to the rope."
    )
    drum_inertia: float = parameter(
        500.0, unit="kg m^2", minimum=1e-6, maximum=1e7, description="Inertia about the drum's axis, motors included."
    )
    load_mass: float = parameter(
        0.0,
        unit="kg",
        minimum=0.0,
        maximum=1e8,
        description="Mass moving rigidly with the rope that the tension does not include.",
    )
    gear_ratio: float = parameter(50.0, unit="", minimum=0.1, maximum=1e4, description="K: motor turns per drum turn.")
    motor_displacement: float = parameter(
        5e-5,
        unit="m^3/rad",
        minimum=1e-9,
        maximum=1.0,
        description="D_m: displacement of all motors together, at full stroke.",
    )
    motor_minimum: float = parameter(
        1.0,
        unit="",
        minimum=0.05,
        maximum=1.0,
        description="Smallest displacement as a fraction of full displacement; 1 is a fixed-displacement motor.",
    )
    motor_time_constant: float = parameter(
        0.1, unit="s", minimum=1e-3, maximum=60.0, description="Time constant of the motors' displacement."
    )
    motor_efficiency: float = parameter(
        0.92, unit="", minimum=0.05, maximum=1.0, description="eta: mechanical efficiency of motors and gear."
    )
    is_passive: bool = parameter(
        True, unit="", description="Losses from efficiency act as friction; false: as a constant factor, as published."
    )
    pump_displacement: float = parameter(
        5e-5,
        unit="m^3/rad",
        minimum=1e-9,
        maximum=1.0,
        description="D_p: displacement of all pumps together, at full swash.",
    )
    pump_speed: float = parameter(
        150.0, unit="rad/s", minimum=0.1, maximum=1e4, description="w_p: speed of the pump shaft."
    )
    swash_time_constant: float = parameter(
        0.05, unit="s", minimum=1e-3, maximum=60.0, description="T_p: time constant of the swash plate."
    )
    swash_input_limit: float = parameter(
        5.0,
        unit="",
        minimum=1.0,
        maximum=1e4,
        description="Largest input of the swash servo, as a fraction of full swash.",
    )
    bulk_modulus: float = parameter(
        1.2e9, unit="Pa", minimum=1e6, maximum=1e11, description="k_b: bulk modulus of the fluid."
    )
    line_volume: float = parameter(
        2e-3, unit="m^3", minimum=1e-6, maximum=10.0, description="V_c: volume of both lines together."
    )
    leakage: float = parameter(
        4e-11,
        unit="m^3/s/Pa",
        minimum=0.0,
        maximum=1e-6,
        description="c: leakage of pump and motors per unit pressure.",
    )
    relief_pressure: float = parameter(
        35e6,
        unit="Pa",
        minimum=0.0,
        maximum=1e9,
        description="Pressure at which the relief valves open; 0: no relief valves.",
    )
    power_limit: float = parameter(
        0.0, unit="W", minimum=0.0, maximum=1e9, description="Largest hydraulic power of the pump; 0: no limit."
    )
    gain: float = parameter(
        1.0,
        unit="",
        minimum=0.0,
        maximum=1e3,
        description="k: gain of the speed loop, from speed error over v_full to swash.",
    )
    integral_time: float = parameter(
        0.3,
        unit="s",
        minimum=1e-3,
        maximum=1e3,
        description="Integral time of the speed loop; unused if its gain is 0.",
    )

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
