"""Parameters of the subsea unit: mass, volume, added mass and drag, and how these depend on its motion and place."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

from heave_node.loads.strength import SAFETY_FACTOR
from heave_node.numerics import hydrostatics
from heave_node.numerics.constants import STANDARD_GRAVITY
from heave_node.parameters import check_ranges, group, parameter


def _check_table(group_name: str, columns: dict[str, tuple[float, ...]]) -> None:
    """Raise ValueError unless the `columns` of a table are of one length and the first one increases."""
    first, *others = columns
    for name in others:
        if len(columns[name]) != len(columns[first]):
            raise ValueError(f"{group_name}.{first} and .{name} must have the same number of values")
    if any(later <= earlier for earlier, later in itertools.pairwise(columns[first])):
        raise ValueError(f"{group_name}.{first} must be strictly increasing")


@dataclass(frozen=True)
class BoxParameters:
    """The box around the unit, which stands on the unit's own point; where its height is given, it may be in air."""

    length: float = parameter(0.0, "m", 0.0, None, "Length of the box; 0: no box.")
    breadth: float = parameter(0.0, "m", 0.0, None, "Breadth of the box.")
    height: float = parameter(0.0, "m", 0.0, None,
        "Height of the box, for its immersion in the splash zone; 0: always under water.")  # fmt: skip
    perforation: float = parameter(0.0, "", 0.0, 0.5,
        "Open fraction of the box's horizontal area; it reduces the added mass.")  # fmt: skip
    slamming: float = parameter(5.0, "", 0.0, None,
        "Slamming coefficient C_s of the underside: force (1/2) rho C_s A U^2 while it enters the water, "
        "A length times breadth, holes included; 0: no slam.")  # fmt: skip

    def __post_init__(self) -> None:
        check_ranges(self)
        if (self.length > 0.0) != (self.breadth > 0.0):
            raise ValueError("unit.box needs length and breadth, or neither")
        if self.height > 0.0 and self.area == 0.0 and self.slamming > 0.0:
            raise ValueError(
                "unit.box.height lets water slam on an underside of unit.box.length and .breadth, which are 0: give "
                "them, or unit.box.slamming = 0"
            )

    @property
    def area(self) -> float:
        """Horizontal area [m^2], holes included."""
        return self.length * self.breadth


@dataclass(frozen=True)
class OscillationParameters:
    """Vertical added mass and drag over the Keulegan-Carpenter number KC = 2 pi z_m / width.

    z_m is the amplitude of the unit's heave through the water, measured as it moves. Values are linear between the
    points and constant beyond them.
    """

    kc: tuple[float, ...] = parameter((), "", 0.0, None, "Keulegan-Carpenter numbers KC, increasing; empty: constant.")
    added_mass: tuple[float, ...] = parameter((), "kg", 0.0, None, "Vertical added mass at each KC.")
    drag_coefficient: tuple[float, ...] = parameter((), "", 0.0, None,
        "Vertical C_D at each KC, for the vertical drag_area.")  # fmt: skip
    width: float = parameter(0.0, "m", 0.0, None, "Length from which KC is computed.")
    memory: float = 60.0  # time constant over which z_m is taken, the square root of 2 times the rms of the heave [s]

    def __post_init__(self) -> None:
        check_ranges(self)
        columns = {"kc": self.kc, "added_mass": self.added_mass, "drag_coefficient": self.drag_coefficient}
        _check_table("unit.oscillation", columns)
        if self.kc and self.width == 0.0:
            raise ValueError("unit.oscillation needs the width that its kc are formed with")


@dataclass(frozen=True)
class UnitParameters:
    """The subsea unit, a point mass with its own added mass and drag along each axis of frame `world`."""

    mass: float = parameter(3000.0, "kg", 1e-6, None, "Mass in air.")
    volume: float = parameter(0.354, "m^3", 0.0, None, "Displaced volume.")
    added_mass: tuple[float, ...] = parameter((3000.0, 3000.0, 3000.0), "kg", 0.0, None,
        "Added mass along x, y, z.", length=3)  # fmt: skip
    vertical_added_mass: str = parameter("given",
        description="given: vertical added mass from added_mass; box: that of `unit.box` by DNV-RP-N103.",
        choices=("given", "box"))  # fmt: skip
    box: BoxParameters = group(BoxParameters)
    oscillation: OscillationParameters = group(OscillationParameters)
    drag_coefficient: tuple[float, ...] = parameter((1.5, 1.5, 1.5), "", 0.0, None, "C_D along x, y, z.", length=3)
    drag_area: tuple[float, ...] = parameter((0.5, 0.5, 0.5), "m^2", 0.0, None,
        "Projected area along x, y, z.", length=3)  # fmt: skip
    # drag along each axis from the speed along it (thesis 5.2.2), or isotropic drag along the flow
    drag_law: str = "per_axis"
    thrust: tuple[float, ...] = (0.0, 0.0, 0.0)  # constant thruster force on the unit, x, y, z [N]
    attachment_breaking_force: float = parameter(0.0, "N", 0.0, None,
        "Breaking force of termination, shackle and padeye at the load; 0: not stated.")  # fmt: skip
    attachment_safety_factor: float = parameter(SAFETY_FACTOR, "", 1.0, 100.0,
        "Required ratio of the attachment's breaking force to its largest load, as cable.safety_factor.")  # fmt: skip

    def __post_init__(self) -> None:
        check_ranges(self)
        if self.vertical_added_mass == "box" and self.box.area == 0.0:
            raise ValueError(
                "unit.vertical_added_mass = box needs unit.box.length and .breadth; .height 0 is a flat plate"
            )
        box = self.box
        content = box.area * box.height
        if content > 0.0 and self.volume > content:
            raise ValueError(
                f"unit.volume is {self.volume:g} m^3, but unit.box of length, breadth and height holds {content:g} m^3"
            )
        grows = self.vertical_added_mass == "box" or self.added_mass[2] > 0.0 or any(self.oscillation.added_mass)
        if content > 0.0 and box.slamming > 0.0 and not grows:
            raise ValueError(
                "unit.box.slamming is the growth of the added mass and needs a vertical added mass: give it in "
                "unit.added_mass, or unit.vertical_added_mass = box, or unit.box.slamming = 0"
            )
        if self.drag_law == "isotropic" and self.oscillation.kc:
            raise ValueError("unit.oscillation is of vertical drag: it needs unit.drag_law = per_axis")
        if self.drag_law == "isotropic":
            products = {c * s for c, s in zip(self.drag_coefficient, self.drag_area, strict=True)}
            if len(products) > 1:
                raise ValueError(
                    "unit.drag_law = isotropic needs the same drag_coefficient times drag_area along x, y and z, got "
                    f"{list(self.drag_coefficient)} and {list(self.drag_area)}"
                )

    def weight_in_fluid(self, density: float, gravity: float = STANDARD_GRAVITY) -> float:
        """Return weight minus buoyancy [N] in a fluid of `density` [kg/m^3] under `gravity` [m/s^2]."""
        return hydrostatics.weight_in_fluid(self.mass, self.volume, density, gravity)
