"""Parameters of the plant: cable, unit, water, seabed, passive compensator, rope path and solver.

`CableSimParameters` is the root; its groups have dotted names (`cable.diameter`, `unit.mass`). Defaults are the 300 m
system of the thesis, section 5.7.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

from heave_node.files.plausible import breaking_words
from heave_node.loads.strength import SAFETY_FACTOR
from heave_node.numerics import hydrostatics
from heave_node.numerics.constants import SEAWATER_DENSITY, STANDARD_GRAVITY
from heave_node.parameters import Checked, check_ranges, group, parameter

from cable_sim_node.unit_parameters import UnitParameters


@dataclass(frozen=True)
class CableParameters(Checked):
    """The main cable. The tension law is T = EA e (1 + quadratic e + cubic e^2) at strain e > 0, none when slack."""

    diameter: float = parameter(0.047, "m", 1e-4, 2.0, "Outer diameter, used for drag.")
    displaced_diameter: float = parameter(0.0, "m", 0.0, 2.0,
        "Diameter used for buoyancy and added mass; 0: the outer diameter.")  # fmt: skip
    mass_per_length: float = parameter(5.4, "kg/m", 1e-4, None, "Mass in air, without added mass.")
    axial_stiffness: float = parameter(1.5614508e7, "N", 1e-3, None, "EA: tension per unit strain at small strain.")
    stiffness_quadratic: float = parameter(0.0, description="q of T = EA e (1 + q e + c e^2) at strain e.")
    stiffness_cubic: float = parameter(0.0, description="c of T = EA e (1 + q e + c e^2) at strain e.")
    internal_damping: float = parameter(0.0, "N s", 0.0, None,
        "Tension per unit strain rate; limited to the elastic tension.")  # fmt: skip
    loss_factor: float = parameter(0.0, "", 0.0, 0.3,
        "Hysteresis by friction between wires: loss per cycle over 2 pi times the peak elastic energy, "
        "at any frequency; 0: none. axial_stiffness applies to large swings; where the loss is largest, "
        "the cable is stiffer by 1.6 times this factor.")  # fmt: skip
    loss_swing: float = parameter(0.1, "", 1e-3, 1.0,
        "Tension amplitude over mean tension at which the loss is largest; at half of it there is none.")  # fmt: skip
    bending_stiffness: float = parameter(0.0, "N m^2", 0.0, None, "EI; 0: a perfectly flexible cable.")
    normal_drag: float = parameter(1.2, "", 0.0, None, "C_N: force (1/2) rho C_N d U^2 per metre.")
    tangential_drag: float = parameter(0.01, "", 0.0, None,
        "C_tau: force (pi/2) rho C_tau d U^2 per metre (other codes' C_d is pi C_tau).")  # fmt: skip
    added_mass: float = parameter(1.0, "", 0.0, None, "Added-mass coefficient normal to the cable.")
    breaking_force: float = parameter(0.0, "N", 0.0, None,
        "Minimum breaking load (MBL) of the cable, for its safety factor; 0: not stated.")  # fmt: skip
    safety_factor: float = parameter(SAFETY_FACTOR, "", 1.0, 100.0,
        "Required ratio of breaking force to largest tension; below it, the run fails. Default: 1.3 x "
        "1.3 x 1.5, GL Noble Denton 0027/ND for steel wire rope.")  # fmt: skip

    @property
    def displaced_area(self) -> float:
        """Cross-section of the displaced water [m^2]."""
        return hydrostatics.displaced_area(self.diameter, self.displaced_diameter)

    def weight_in_fluid(self, density: float, gravity: float = STANDARD_GRAVITY) -> float:
        """Return weight minus buoyancy [N/m] in a fluid of `density` [kg/m^3] under `gravity` [m/s^2]."""
        return hydrostatics.weight_in_fluid(self.mass_per_length, self.displaced_area, density, gravity)


@dataclass(frozen=True)
class SectionsParameters:
    """Sections of other cable between unit and main cable, from the unit upwards; one entry a section in each list.

    Tension law, damping, hysteresis, bending stiffness and hydrodynamic coefficients are those of the main cable.
    """

    length: tuple[float, ...] = parameter((), "m", 1e-3, None, "Unstretched length of each section, from the unit.")
    diameter: tuple[float, ...] = parameter((), "m", 1e-4, None, "Outer diameter of each section.")
    displaced_diameter: tuple[float, ...] = parameter((), "m", 0.0, None,
        "Displaced diameter of each section; an empty list or 0: the outer diameter.")  # fmt: skip
    mass_per_length: tuple[float, ...] = parameter((), "kg/m", 1e-4, None, "Mass in air of each section.")
    axial_stiffness: tuple[float, ...] = parameter((), "N", 1e-3, None, "EA of each section.")

    def __post_init__(self) -> None:
        check_ranges(self)
        for name in ("diameter", "mass_per_length", "axial_stiffness"):
            count = len(getattr(self, name))
            if count != len(self.length):
                raise ValueError(
                    f"sections.{name} has {count} values but sections.length {len(self.length)}: give one per section"
                )
        if self.displaced_diameter and len(self.displaced_diameter) != len(self.length):
            raise ValueError("sections.displaced_diameter must be empty or have one value per section")


@dataclass(frozen=True)
class SecondLineParameters:
    """A second line to the unit, as an umbilical; drag and damping are the main cable's, its length stays."""

    length: float = parameter(0.0, "m", 0.0, None, "Unstretched length; 0: there is none.")
    at: tuple[float, ...] = parameter((10.0, 0.0, 0.0), "m", -500.0, 500.0,
        "Its top from the boom tip, with which it moves.", length=3)  # fmt: skip
    diameter: float = parameter(0.03, "m", 1e-4, 2.0, "Outer diameter.")
    mass_per_length: float = parameter(1.2, "kg/m", 1e-4, None, "Mass in air.")
    axial_stiffness: float = parameter(5e6, "N", 1.0, None, "EA.")
    segments: int = 20  # that it is cut into [-]


@dataclass(frozen=True)
class ClumpsParameters:
    """Bodies clamped on the cable (weights, floats); one entry a body in each list. Drag is (1/2) rho drag_area U^2."""

    position: tuple[float, ...] = parameter((), "m", 1e-3, None, "Unstretched length from the unit to each body.")
    mass: tuple[float, ...] = parameter((), "kg", 0.0, None, "Mass in air of each body.")
    volume: tuple[float, ...] = parameter((), "m^3", 0.0, None, "Displaced volume of each body.")
    added_mass: tuple[float, ...] = parameter((), "kg", 0.0, None, "Added mass of each body.")
    drag_area: tuple[float, ...] = parameter((), "m^2", 0.0, None, "Drag coefficient times area of each body.")

    def __post_init__(self) -> None:
        check_ranges(self)
        for name in ("mass", "volume", "added_mass", "drag_area"):
            count = len(getattr(self, name))
            if count != len(self.position):
                raise ValueError(
                    f"clumps.{name} has {count} values but clumps.position {len(self.position)}: give one per body"
                )


@dataclass(frozen=True)
class SeabedProfileParameters:
    """Hills and valleys of the seabed along one direction, on its plane.

    A smooth curve joins the points; beyond them the height stays that of the last one.
    """

    distance: tuple[float, ...] = parameter((), "m",
        description="Distances from the origin along `direction`, increasing; empty: a plane.")  # fmt: skip
    height: tuple[float, ...] = parameter((), "m", description="Height of the bottom above the plane at each distance.")
    direction: float = parameter(0.0, "rad", description="Direction of the profile, from x towards y.")

    def __post_init__(self) -> None:
        check_ranges(self)
        if len(self.distance) != len(self.height):
            raise ValueError("seabed.profile.distance and .height must have the same number of values")
        if len(self.distance) == 1:
            raise ValueError("seabed.profile needs two points at least, or none")
        if any(later <= earlier for earlier, later in itertools.pairwise(self.distance)):
            raise ValueError("seabed.profile.distance must be strictly increasing")


@dataclass(frozen=True)
class SeabedParameters:
    """The seabed, elastic with friction. Contact forces of the cable are per unstretched metre.

    Stiffness and damping hold along the bottom as well, up to the Coulomb force: what stands within it stays at rest.
    A deck is a level bottom that goes up and down with the boom tip, and stays where it is otherwise.
    """

    depth: float = parameter(0.0, "m", 0.0, None, "Water depth below the origin; 0: no seabed.")
    deck: bool = parameter(False,
        description="The bottom is the ship's deck: level, and always `depth` below the boom tip.")  # fmt: skip
    slope: tuple[float, ...] = parameter((0.0, 0.0),
        description="Rise of the bottom per metre along x and y.", length=2)  # fmt: skip
    profile: SeabedProfileParameters = group(SeabedProfileParameters)
    stiffness: float = 1e4  # normal force per metre of cable and metre of penetration [N/m^2]
    damping: float = 1e3  # normal damping per metre of cable [N s/m^2]
    friction: float = parameter(0.5, "", 0.0, 5.0, "Coulomb coefficient.")
    unit_stiffness: float = parameter(1e6, "N/m", 1.0, None, "Normal stiffness under the unit.")
    unit_damping: float = parameter(1e5, "N s/m", 0.0, None, "Normal damping under the unit.")

    def __post_init__(self) -> None:
        check_ranges(self)
        if self.deck and (any(self.slope) or self.profile.distance):
            raise ValueError("seabed.deck: a deck is level, without seabed.slope and seabed.profile")


@dataclass(frozen=True)
class CurrentProfileParameters:
    """A sheared current that replaces the uniform `current`; straight between the points, constant beyond them."""

    depth: tuple[float, ...] = parameter((), "m", description="Depths of the profile, increasing; empty: uniform.")
    velocity_x: tuple[float, ...] = parameter((), "m/s", description="Velocity along x at each depth.")
    velocity_y: tuple[float, ...] = parameter((), "m/s", description="Velocity along y at each depth.")

    def __post_init__(self) -> None:
        check_ranges(self)
        if not len(self.depth) == len(self.velocity_x) == len(self.velocity_y):
            raise ValueError("current_profile.depth, .velocity_x and .velocity_y must have the same number of values")
        if any(later <= earlier for earlier, later in itertools.pairwise(self.depth)):
            raise ValueError("current_profile.depth must be strictly increasing")


@dataclass(frozen=True)
class WaveKinematicsParameters:
    """The waves that act on cable and unit: motion of the water and the surface, linear in deep water."""

    source: str = parameter("none",
        description="none: still water; regular: one wave of this amplitude and period; sea: the sea that moves "
        "the vessel (boom_tip_source spectrum or regular).", choices=("none", "regular", "sea"))  # fmt: skip
    amplitude: float = parameter(0.0, "m", 0.0, None, "Source regular: wave amplitude.")
    period: float = parameter(10.0, "s", 0.5, None, "Source regular: wave period.")
    direction: float = parameter(0.0, "rad",
        description="Source regular: direction the wave travels to, from x towards y.")  # fmt: skip

    def __post_init__(self) -> None:
        check_ranges(self)
        if self.amplitude > 0.0 and self.source != "regular":
            raise ValueError(f"wave.amplitude needs wave.source = regular; it is {self.source}")
        if self.source == "regular" and self.amplitude == 0.0:
            raise ValueError("wave.source = regular needs wave.amplitude; still water is wave.source = none")
        words = breaking_words(2.0 * self.amplitude, self.period)
        if words:
            raise ValueError(f"wave: {words}")


@dataclass(frozen=True)
class CompensatorParameters(Checked):
    """A passive compensator that carries the sheave: spring and damper with end stops, working along the vertical."""

    stiffness: float = parameter(0.0, "N/m", 0.0, None, "Spring stiffness; 0: no compensator.")
    damping: float = parameter(0.0, "N s/m", 0.0, None, "Damping of the compensator.")
    moving_mass: float = 500.0  # that moves with the sheave [kg]
    stroke: float = parameter(4.0, "m", 1e-3, None, "Full stroke; the end stops are at plus and minus half of it.")
    stop_stiffness: float = 2e6  # stiffness of the end stops [N/m]
    stop_damping: float = 2e5  # damping of the end stops [N s/m]; the stops never pull
    preload: float = 0.0  # force at mid-stroke [N]; 0 means the static top tension at the start of the run


@dataclass(frozen=True)
class RopePathParameters:
    """The rope's way from the drum over its sheaves to the boom tip: friction before the load cell, and what gives."""

    friction: float = parameter(0.0, "", 0.0, 2.0,
        "ln of the tension ratio across the sheaves of a running rope: mu theta (Euler and Eytelwein), or "
        "-n ln e for n sheaves of efficiency e. The load cell is on the drum side; 0: none.",
    )  # fmt: skip
    stiffness: float = parameter(0.0, "N/m", 0.0, None,
        "Stiffness of boom, sheaves and rope between drum and boom tip, in series: a vertical spring "
        "above the cable. 0: rigid, without friction.",
    )  # fmt: skip

    def __post_init__(self) -> None:
        check_ranges(self)
        if self.friction > 0.0 and self.stiffness == 0.0:
            raise ValueError("rope_path.friction needs rope_path.stiffness above 0")


@dataclass(frozen=True)
class SolverParameters(Checked):
    """Settings of the time integration (generalised-alpha)."""

    time_step: float = 0.05  # largest inner step; an interval is divided into equal steps of at most this [s]
    # amplitude of the fastest oscillation that remains after a step: 1 keeps all energy, 0 removes it at once [-]
    spectral_radius: float = 0.8
    tolerance: float = 1e-4  # largest Newton correction accepted as converged, in segment lengths [-]
    iterations: int = 12  # Newton iterations before a step is halved [-]


@dataclass(frozen=True)
class CableSimParameters:
    """Everything the plant needs. At payout 0 the unstretched length between unit and boom tip is `length`."""

    length: float = parameter(300.0, "m", 0.01, 20000.0, "Unstretched cable length at payout 0.")
    segments: int = parameter(50, "", 1, 5000, "Segments that `length` is divided into.")
    current: tuple[float, ...] = parameter((0.0, 0.0), "m/s", -10.0, 10.0,
        "Current along x and y, uniform unless a profile is given.", length=2)  # fmt: skip
    water_density: float = parameter(SEAWATER_DENSITY, "kg/m^3", 0.0, 2000.0,
        "Density of the surrounding fluid; 0: vacuum.")  # fmt: skip
    surface: bool = parameter(True,
        description="Water up to z = 0 and the wave; false: water everywhere.",
    )  # fmt: skip
    gravity: float = parameter(STANDARD_GRAVITY, "m/s^2", 0.0, 100.0, "Acceleration of gravity.")
    cable: CableParameters = group(CableParameters)
    unit: UnitParameters = group(UnitParameters)
    sections: SectionsParameters = group(SectionsParameters)
    clumps: ClumpsParameters = group(ClumpsParameters)
    second_line: SecondLineParameters = group(SecondLineParameters)
    seabed: SeabedParameters = group(SeabedParameters)
    current_profile: CurrentProfileParameters = group(CurrentProfileParameters)
    wave: WaveKinematicsParameters = group(WaveKinematicsParameters)
    compensator: CompensatorParameters = group(CompensatorParameters)
    rope_path: RopePathParameters = group(RopePathParameters)
    solver: SolverParameters = group(SolverParameters)

    def __post_init__(self) -> None:
        check_ranges(self)
        if self.compensator.stiffness > 0.0 and self.rope_path.stiffness > 0.0:
            raise ValueError(
                "compensator.stiffness and rope_path.stiffness are both a spring under the boom tip: give one of them "
                "(1/k = 1/k1 + 1/k2)"
            )

    @property
    def top_spring(self) -> CompensatorParameters:
        """What carries the sheave: the compensator, or boom and rope path, without stops, of the least mass."""
        if self.rope_path.stiffness == 0.0:
            return self.compensator
        return CompensatorParameters(stiffness=self.rope_path.stiffness, moving_mass=1.0, stroke=1e9)
