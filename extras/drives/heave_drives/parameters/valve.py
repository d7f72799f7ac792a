"""Parameters of the valve-controlled hydraulic drive; `valve_controlled` says what they mean."""

from __future__ import annotations

from dataclasses import dataclass

from heave_node.parameters import Checked, check_ranges, group, parameter

from heave_drives.parameters.motion import FrictionParameters, MotionParameters


@dataclass(frozen=True)
class FluidParameters(Checked):
    """Oil in the lines between valve and motors."""

    bulk_modulus: float = 1.1e9  # bulk modulus of the oil alone [Pa]
    trapped_air: float = 0.005  # volume fraction of air, at atmospheric pressure [-]
    line_volume: float = 6e-4  # volume of each of the two lines, valve to motors [m^3]
    leakage: float = parameter(1e-11, "m^3/s/Pa", 0.0, 1e-6, "Leakage of the motors per unit pressure difference.")


@dataclass(frozen=True)
class ServoValveParameters(Checked):
    """All servo valves together, on one set-point."""

    rated_flow: float = parameter(800.0 / 6e4, "m^3/s", 1e-6, 10.0, "Flow at the rated pressure drop, fully open.")
    rated_drop: float = 35e5  # rated pressure drop across one control edge [Pa]
    frequency: float = parameter(314.159, "rad/s", 1.0, 1e4, "Natural frequency of the spool.")
    damping: float = parameter(1.0, "", 0.05, 5.0, "Damping ratio of the spool.")
    input_limit: float = 1.0  # largest spool set-point, as a fraction of full stroke [-]
    laminar_pressure: float = 5e4  # pressure drop below which the flow of an edge is linear in it [Pa]


@dataclass(frozen=True)
class SupplyParameters:
    """The hydraulic power unit. Pressures are above atmospheric, as gauges read them."""

    pressure: float = parameter(24e6, "Pa", 1e5, 1e8, "Set pressure of the hydraulic power unit.")
    accumulator_volume: float = parameter(0.0, "m^3", 0.0, 100.0,
        "Gas volume at precharge; 0: constant supply pressure.")  # fmt: skip
    precharge: float = parameter(16e6, "Pa", 1e5, 1e8, "Gas pressure of the empty accumulator, above atmospheric.")
    pump_flow: float = parameter(2000.0 / 6e4, "m^3/s", 1e-6, 10.0, "Largest pump flow; used with an accumulator.")
    pump_rate: float = 6.0  # bandwidth of the pump flow (reciprocal of its time constant) [1/s]
    droop: float = 1e6  # pressure drop below the set pressure at which the pump delivers its full flow [Pa]

    def __post_init__(self) -> None:
        check_ranges(self)
        if self.accumulator_volume > 0.0 and self.precharge >= self.pressure:
            raise ValueError(
                f"supply.precharge = {self.precharge:g} Pa must be below supply.pressure = {self.pressure:g} Pa"
            )


@dataclass(frozen=True)
class ValveControlledParameters(Checked):
    """Supply, servo valves, motors and speed loop of a valve-controlled hydraulic winch.

    The defaults are a drawworks of 24 t on six parts of rope.
    """

    friction: FrictionParameters = group(FrictionParameters, load=0.15, slip_speed=0.008)
    fluid: FluidParameters = group(FluidParameters)
    valve: ServoValveParameters = group(ServoValveParameters)
    supply: SupplyParameters = group(SupplyParameters)
    motor_displacement: float = parameter(3e-5, "m^3/rad", 1e-9, 1.0, "Displacement of all motors together.")
    motor_radians_per_metre: float = parameter(600.0, "rad/m", 0.1, 1e6, "Motor rotation per metre of payout.")
    motor_inertia: float = parameter(0.01, "kg m^2", 1e-9, 1e5,
        "Inertia of all motors and everything that turns with them.")  # fmt: skip
    load_mass: float = 0.0  # mass moving rigidly with the rope [kg]; its weight is part of the tension
    gain: float = parameter(0.1, "s/m", 0.0, 1e4,
        "Gain of the speed loop: spool position (fraction of full) per speed error.")  # fmt: skip
    feed_forward: float = parameter(1.0, "s/m", 0.0, 1e3,
        "Feed-forward: spool position (fraction of full) per speed set-point.")  # fmt: skip
    integral_time: float = parameter(0.01, "s", 1e-3, 1e9, "Integral time of the speed loop.")

    @property
    def area(self) -> float:
        """A: flow of the motors per rope speed, force per pressure [m^2]."""
        return self.motor_displacement * self.motor_radians_per_metre

    @property
    def mass(self) -> float:
        """M: mass that the rope feels [kg]."""
        return self.motor_inertia * self.motor_radians_per_metre**2 + self.load_mass


@dataclass(frozen=True)
class ValveDriveParameters(ValveControlledParameters):
    """A valve-controlled drive on its own: with what its motion is kept within, which in a winch is the winch's."""

    motion: MotionParameters = group(MotionParameters, speed_limit=1.2)
