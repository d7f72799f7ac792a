"""Parameters of the valve-controlled hydraulic drive; `valve_controlled` says what they mean."""

from __future__ import annotations

from dataclasses import dataclass

from heave_node.parameters import Checked, check_ranges, group, parameter

from heave_drives.parameters.motion import FrictionParameters, MotionParameters


@dataclass(frozen=True)
class FluidParameters(Checked):
    """Oil in the lines between valve and motors."""

    bulk_modulus: float = parameter(
        1.1e9, unit="Pa", minimum=1e6, maximum=1e11, description="Bulk modulus of the oil alone."
    )
    trapped_air: float = parameter(
        0.005, unit="", minimum=0.0, maximum=0.5, description="Volume fraction of air, at atmospheric pressure."
    )
    line_volume: float = parameter(
        6e-4, unit="m^3", minimum=1e-6, maximum=10.0, description="Volume of each of the two lines, valve to motors."
    )
    leakage: float = parameter(
        1e-11,
        unit="m^3/s/Pa",
        minimum=0.0,
        maximum=1e-6,
        description="Leakage of the motors per unit pressure difference.",
    )


@dataclass(frozen=True)
class ServoValveParameters(Checked):
    """All servo valves together, on one set-point."""

    rated_flow: float = parameter(
        800.0 / 6e4,
        unit="m^3/s",
        minimum=1e-6,
        maximum=10.0,
        description="Flow at the rated pressure drop, fully open.",
    )
    rated_drop: float = parameter(
        35e5, unit="Pa", minimum=1e3, maximum=1e8, description="Rated pressure drop across one control edge."
    )
    frequency: float = parameter(
        314.159, unit="rad/s", minimum=1.0, maximum=1e4, description="Natural frequency of the spool."
    )
    damping: float = parameter(1.0, unit="", minimum=0.05, maximum=5.0, description="Damping ratio of the spool.")
    input_limit: float = parameter(
        1.0, unit="", minimum=1.0, maximum=1e6, description="Largest spool set-point, as a fraction of full stroke."
    )
    laminar_pressure: float = parameter(
        5e4,
        unit="Pa",
        minimum=100.0,
        maximum=1e7,
        description="Pressure drop below which the flow of an edge is linear in it.",
    )


@dataclass(frozen=True)
class SupplyParameters:
    """The hydraulic power unit. Pressures are above atmospheric, as gauges read them."""

    pressure: float = parameter(
        24e6, unit="Pa", minimum=1e5, maximum=1e8, description="Set pressure of the hydraulic power unit."
    )
    accumulator_volume: float = parameter(
        0.0, unit="m^3", minimum=0.0, maximum=100.0, description="Gas volume at precharge; 0: constant supply pressure."
    )
    precharge: float = parameter(
        16e6,
        unit="Pa",
        minimum=1e5,
        maximum=1e8,
        description="Gas pressure of the empty accumulator, above atmospheric.",
    )
    pump_flow: float = parameter(
        2000.0 / 6e4,
        unit="m^3/s",
        minimum=1e-6,
        maximum=10.0,
        description="Largest pump flow; used with an accumulator.",
    )
    pump_rate: float = parameter(
        6.0,
        unit="1/s",
        minimum=0.01,
        maximum=1e3,
        description="Bandwidth of the pump flow (reciprocal of its time constant).",
    )
    droop: float = parameter(
        1e6,
        unit="Pa",
        minimum=1e3,
        maximum=1e8,
        description="Pressure drop below the set pressure at which the pump delivers its full flow.",
    )

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
    motor_displacement: float = parameter(
        3e-5, unit="m^3/rad", minimum=1e-9, maximum=1.0, description="Displacement of all motors together."
    )
    motor_radians_per_metre: float = parameter(
        600.0, unit="rad/m", minimum=0.1, maximum=1e6, description="Motor rotation per metre of payout."
    )
    motor_inertia: float = parameter(
        0.01,
        unit="kg m^2",
        minimum=1e-9,
        maximum=1e5,
        description="Inertia of all motors and everything that turns with them.",
    )
    load_mass: float = parameter(
        0.0,
        unit="kg",
        minimum=0.0,
        maximum=1e8,
        description="Mass moving rigidly with the rope; its weight is part of the tension.",
    )
    gain: float = parameter(
        0.1,
        unit="s/m",
        minimum=0.0,
        maximum=1e4,
        description="Gain of the speed loop: spool position (fraction of full) per speed error.",
    )
    feed_forward: float = parameter(
        1.0,
        unit="s/m",
        minimum=0.0,
        maximum=1e3,
        description="Feed-forward: spool position (fraction of full) per speed set-point.",
    )
    integral_time: float = parameter(
        0.01, unit="s", minimum=1e-3, maximum=1e9, description="Integral time of the speed loop."
    )

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
