"""Added mass by the simplified expressions, beside the recommended practice's own tables and hand calculation."""

import itertools
import math

import pytest
from cable_sim_node.parameters import CableSimParameters
from cable_sim_node.physics.hydrodynamics import box_added_mass, perforation_factor, plate_added_mass
from cable_sim_node.physics.properties import unit_properties
from cable_sim_node.unit_parameters import BoxParameters, OscillationParameters, UnitParameters

SQUARE_PRISMS = {1.0: 0.68, 2.0: 0.36, 3.0: 0.24, 4.0: 0.19, 5.0: 0.15, 7.0: 0.11}
"""DNV-RP-H103, table A-2: height over side of a square prism, and C_A of its motion along itself, of rho a^2 b."""


@pytest.mark.parametrize(("ratio", "coefficient"), SQUARE_PRISMS.items())
def test_a_box_has_the_added_mass_of_the_square_prism_in_the_table(ratio, coefficient):
    """The expression for bodies with vertical sides is an approximation: it is within 6 % of the table's two digits."""
    assert box_added_mass(1.0, 1.0, ratio, 1.0) / ratio == pytest.approx(coefficient, rel=0.06)


def test_a_plate_has_the_coefficient_of_the_table_and_a_long_one_that_of_a_strip():
    """3 m square: 0.579 x 1025 x pi/4 x 27 = 12,585 kg. A strip: rho pi/4 a^2 per metre, exact in potential flow."""
    assert plate_added_mass(3.0, 3.0, 1025.0) == pytest.approx(12585.0, abs=1.0)
    assert plate_added_mass(2.0, 3.0, 1.0) / (3.0 * math.pi) == pytest.approx(0.690, abs=1e-9)
    assert plate_added_mass(6.0, 2.0, 1.0) / (6.0 * math.pi) == pytest.approx(0.830, abs=1e-9)
    assert plate_added_mass(2.0, 4.0, 1025.0) == plate_added_mass(4.0, 2.0, 1025.0)
    assert plate_added_mass(1e6, 1.0, 1025.0) == pytest.approx(1025.0 * math.pi / 4.0 * 1e6, rel=1e-6)
    assert plate_added_mass(0.0, 0.0, 1025.0) == box_added_mass(0.0, 0.0, 1.0, 1025.0) == 0.0


def test_a_box_without_height_is_a_plate_and_a_tall_one_has_the_limit_of_the_expression():
    """k = 1 without height; k = 0 for one that is tall without end: 1 + 1/sqrt(2)."""
    plate = plate_added_mass(3.0, 4.0, 1025.0)
    assert box_added_mass(3.0, 4.0, 0.0, 1025.0) == pytest.approx(plate)
    assert box_added_mass(3.0, 4.0, 1e9, 1025.0) == pytest.approx(plate * (1.0 + math.sqrt(0.5)))


@pytest.mark.parametrize(
    ("perforation", "factor"),
    # 0.7 + 0.3 cos(15 pi/34) and exp(-30/28), by hand
    [(0.0, 1.0), (0.05, 1.0), (0.2, 0.7551), (0.4, 0.3425)],
)
def test_holes_reduce_the_added_mass_as_the_expression_says(perforation, factor):
    assert perforation_factor(perforation) == pytest.approx(factor, abs=1e-4)
    assert box_added_mass(3.0, 3.0, 2.0, 1025.0, perforation) == pytest.approx(
        factor * box_added_mass(3.0, 3.0, 2.0, 1025.0), rel=2e-4
    )


def test_holes_never_raise_the_added_mass():
    factors = [perforation_factor(0.005 * k) for k in range(101)]
    assert all(later <= earlier for earlier, later in itertools.pairwise(factors))


def test_a_unit_takes_the_vertical_added_mass_of_its_box():
    box = BoxParameters(length=4.0, breadth=3.0, height=2.0, perforation=0.2)
    unit = UnitParameters(mass=1e4, added_mass=(1e3, 2e3, 5e4), vertical_added_mass="box", box=box)
    wanted = box_added_mass(4.0, 3.0, 2.0, 1025.0, 0.2)
    properties = unit_properties(CableSimParameters(unit=unit))
    assert properties.inertia == pytest.approx([1.1e4, 1.2e4, 1e4 + wanted])
    in_vacuum = unit_properties(CableSimParameters(unit=unit, water_density=0.0))
    assert in_vacuum.inertia == pytest.approx([1e4, 1e4, 1e4])


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"vertical_added_mass": "box"}, r"needs unit.box.length and .breadth; .height 0 is a flat plate"),
        ({"box": (BoxParameters, {"height": 4.0})}, r"^unit.box.height .* give them, or unit.box.slamming = 0$"),
        (
            {"box": (BoxParameters, {"length": 5.0, "breadth": 4.0, "height": 4.0}), "added_mass": [1e3, 1e3, 0.0]},
            r"^unit.box.slamming .* needs a vertical added mass",
        ),
        (
            {"box": (BoxParameters, {"length": 1.0, "breadth": 1.0, "height": 1.0}), "volume": 8.0},
            r"^unit.volume is 8 m\^3, but unit.box .* holds 1 m\^3",
        ),
        ({"box": (BoxParameters, {"length": 3.0})}, "needs length and breadth"),
        ({"oscillation": (OscillationParameters, {"kc": (1.0, 2.0), "width": 1.0})}, "same number of values"),
        (
            {"oscillation": (OscillationParameters, {"kc": (1.0,), "added_mass": (1.0,), "drag_coefficient": (1.0,)})},
            "needs the width",
        ),
        (
            {
                "oscillation": (
                    OscillationParameters,
                    {"kc": (2.0, 1.0), "added_mass": (1.0, 1.0), "drag_coefficient": (1.0, 1.0), "width": 1.0},
                )
            },
            "strictly increasing",
        ),
    ],
)
def test_a_unit_that_contradicts_itself_is_refused_with_what_is_missing(given, words):
    with pytest.raises(ValueError, match=words):
        UnitParameters(
            **{name: value[0](**value[1]) if isinstance(value, tuple) else value for name, value in given.items()}
        )
