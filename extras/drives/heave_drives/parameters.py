"""Parameters of the drives of a winch: what every drive has, then electric, pump-controlled and valve-controlled."""

from __future__ import annotations

import math
from dataclasses import dataclass

from heave_node.parameters import Checked, check_ranges, group, parameter


@dataclass(frozen=True)
class MotionParameters:
    """What the rope's motion is kept within."""

    speed_limit: float = parameter(2.0, "m/s", 1e-3, 100.0, "Largest speed set-point; larger ones are clipped.")
    overspeed: float = parameter(1.1, "", 0.0, 10.0,
        "Overspeed at which the brake trips, as a multiple of speed_limit; 0: no overspeed trip.")  # fmt: skip
    payout_minimum: float = parameter(-50.0, "m", -20_000.0, 20_000.0, "Lower end of the payout range.")
    payout_maximum: float = parameter(50.0, "m", -20_000.0, 20_000.0, "Upper end of the payout range.")
    stop_deceleration: float = parameter(1.5, "m/s^2", 1e-3, 1e6,
        "Deceleration under the brake and ahead of an end stop.")  # fmt: skip
    position_gain: float = parameter(0.0, "1/s", 0.0, 100.0,
        "Gain from payout error to speed; 0 follows the rate set-point alone.")  # fmt: skip

    def __post_init__(self) -> None:
        check_ranges(self)
        if not self.payout_minimum <= 0.0 <= self.payout_maximum or self.payout_minimum == self.payout_maximum:
            raise ValueError(
                f"payout 0, where the drive starts, must be from payout_minimum = {self.payout_minimum:g} m to "
                f"payout_maximum = {self.payout_maximum:g} m, and these must differ"
            )
        if 0.0 < self.overspeed < 1.0:
            raise ValueError(f"overspeed = {self.overspeed:g} must be 0 or at least 1: it is above speed_limit")


@dataclass(frozen=True)
class FrictionParameters(Checked):
    """Friction of bearings, gear and sheaves, as a force at the rope, against the motion."""

    coulomb: float = 0.0  # independent of load [N]
    load: float = 0.0  # fraction of tension [-]
    slip_speed: float = 0.01  # rope speed at which the two frictions above reach 76 % of their value [m/s]
    viscous: float = 0.0  # proportional to speed [N s/m]

    def rate(self, tension: float, mass: float) -> float:
        """Return how fast friction alone would stop `mass` [kg] near rest under `tension` [N], as 1/time [1/s]."""
        return ((self.coulomb + self.load * tension) / self.slip_speed + self.viscous) / mass


LAYER_PITCH = 0.5 * math.sqrt(3.0)
"""Radius from layer to layer, in rope diameters: round rope in the grooves of the layer below."""


@dataclass(frozen=True)
class SpoolParameters(Checked):
    """Drum, rope and reeving."""

    drum_radius: float = parameter(0.5, "m", 0.01, 20.0, "Radius from the drum's axis to its surface.")
    rope_diameter: float = parameter(0.047, "m", 0.001, 0.5, "Diameter of the rope.")
    turns_per_layer: int = parameter(0, "", 0, 1000, "Turns of rope in a layer; 0: the radius does not change.")
    rope_at_zero: float = parameter(0.0, "m", 0.0, 50_000.0, "Rope on the drum at payout 0.")
    falls: int = parameter(1, "", 1, 32, "Falls of rope that carry the load (reeving).")

    def check_rope(self, payout_maximum: float) -> None:
        """Raise ValueError where `payout_maximum` [m] needs more rope than there is on the drum."""
        needed = self.falls * payout_maximum
        if self.turns_per_layer > 0 and needed > self.rope_at_zero:
            raise ValueError(
                f"payout_maximum = {payout_maximum:g} m with {self.falls} falls needs {needed:g} m of rope; "
                f"spool.rope_at_zero = {self.rope_at_zero:g} m"
            )

    def radius_of_layer(self, layer: int) -> float:
        """Return the radius of the rope's centre line in a layer [m], counted from 0."""
        return self.drum_radius + self.rope_diameter * (0.5 + LAYER_PITCH * layer)


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
    copper_loss: float = 10e3  # copper loss at torque_limit; proportional to torque^2 [W]
    reference_time: float = 0.05  # time constant with which the speed reference follows the set-point [s]
    bandwidth: float = 20.0  # gain of the speed loop, divided by mass [rad/s]
    integral_time: float = 0.3  # integral time of the speed loop [s]
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
        "Smallest displacement, as a fraction of the full one; 1: fixed displacement.")  # fmt: skip
    motor_time_constant: float = 0.1  # time constant of the motors' displacement [s]
    motor_efficiency: float = 0.92  # eta: mechanical efficiency of motors and gear [-]
    is_passive: bool = True  # losses from efficiency act as friction; false: as a constant factor, as published
    pump_displacement: float = parameter(5e-5, "m^3/rad", 1e-9, 1.0,
        "D_p: displacement of all pumps together, at full swash.")  # fmt: skip
    pump_speed: float = parameter(150.0, "rad/s", 0.1, 1e4, "w_p: speed of the pump shaft.")
    swash_time_constant: float = 0.05  # T_p: time constant of the swash plate [s]
    swash_input_limit: float = 5.0  # largest input of the swash servo, as a fraction of full swash [-]
    bulk_modulus: float = 1.2e9  # k_b: bulk modulus of the fluid [Pa]
    line_volume: float = 2e-3  # V_c: volume of both lines together [m^3]
    leakage: float = 4e-11  # c: leakage of pump and motors per unit pressure [m^3/s/Pa]
    relief_pressure: float = parameter(35e6, "Pa", 0.0, 1e9,
        "Pressure at which the relief valves open; 0: no relief valves.")  # fmt: skip
    power_limit: float = parameter(0.0, "W", 0.0, 1e9, "Largest hydraulic power of the pump; 0: no limit.")
    gain: float = 1.0  # k: gain of the speed loop, from speed error over v_full to swash [-]
    integral_time: float = 0.3  # integral time of the speed loop; unused if its gain is 0 [s]

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


@dataclass(frozen=True)
class FluidParameters(Checked):
    """Oil in the lines between valve and motors."""

    bulk_modulus: float = 1.1e9  # bulk modulus of the oil alone [Pa]
    trapped_air: float = 0.005  # volume fraction of air, at atmospheric pressure [-]
    line_volume: float = 6e-4  # volume of each of the two lines, valve to motors [m^3]
    leakage: float = 1e-11  # leakage of the motors per unit pressure difference [m^3/s/Pa]


@dataclass(frozen=True)
class ServoValveParameters(Checked):
    """All servo valves together, on one set-point."""

    rated_flow: float = parameter(800.0 / 6e4, "m^3/s", 1e-6, 10.0, "Flow at the rated pressure drop, fully open.")
    rated_drop: float = 35e5  # rated pressure drop across one control edge [Pa]
    frequency: float = 314.159  # natural frequency of the spool [rad/s]
    damping: float = 1.0  # damping ratio of the spool [-]
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
    gain: float = 0.1  # gain of the speed loop: spool position over full per speed error [s/m]
    feed_forward: float = 1.0  # spool position over full per speed set-point [s/m]
    integral_time: float = 0.01  # integral time of the speed loop [s]

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
