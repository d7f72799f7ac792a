"""The catalogue: particulars as their sources print them, and names that stand for values."""

import math

import pytest
from heave_node.catalogue import KINDS, entries, find, with_entries
from heave_node.parameters import Given, ParameterError
from heave_node.system_parameters import take_system


def given(**values):
    return {
        name.replace("__", "."): Given(value, name.replace("__", "."), "f.yaml: /**") for name, value in values.items()
    }


@pytest.mark.parametrize(
    ("name", "mass", "force"),
    [
        # tables of ropes of class 6x36 by EN 12385-4, grade 1770: kg/100 m and kN, as makers round them
        ("wire_16mm_6x36", 105.0, 161.0),
        ("wire_28mm_6x36", 321.0, 494.0),
        ("wire_40mm_6x36", 654.0, 1010.0),
        ("wire_16mm_6x36_fibre_core", 94.0, 150.0),
        ("wire_28mm_6x36_fibre_core", 288.0, 458.0),
    ],
)
def test_a_wire_has_the_mass_and_breaking_force_of_the_tables(name, mass, force):
    wire = find("cable", name)
    assert 100.0 * wire.values["mass_per_length"] == pytest.approx(mass, rel=0.005)
    assert 1e-3 * wire.breaking_force == pytest.approx(force, rel=0.005)


def test_the_steel_of_a_wire_rope_is_as_dense_as_steel_and_fibre_rope_floats():
    def density(name):
        values = find("cable", name).values
        return values["mass_per_length"] / (0.25 * math.pi * values["displaced_diameter"] ** 2)

    assert density("wire_28mm_6x36") == pytest.approx(7850.0, rel=0.05)
    assert density("hmpe_40mm") == pytest.approx(975.0, rel=0.01)


def test_a_wire_is_less_stiff_than_a_steel_bar_of_its_steel():
    for name, wire in entries("cable").items():
        if name.startswith("wire"):
            steel = wire.values["mass_per_length"] / 7850.0  # area, were all wires straight [m^2]
            assert 0.3 * 205e9 < wire.values["axial_stiffness"] / steel < 205e9


@pytest.mark.parametrize("kind", KINDS)
def test_every_entry_says_what_it_is_and_where_it_is_from(kind):
    assert len(entries(kind)) >= 3
    for entry in entries(kind).values():
        assert entry.title
        assert all(len(source) > 20 for source in entry.sources)
        assert entry.sources


def test_a_name_stands_for_its_values_and_what_is_given_beside_it_wins():
    named = with_entries(given(system__cable="wire_28mm_6x36", system__length=1500.0))
    assert named["system.cable.diameter"].value == 0.028
    assert named["system.length"].value == 1500.0
    assert "system.cable" not in named
    changed = with_entries(given(system__cable__from="wire_28mm_6x36", system__cable__diameter=0.03))
    assert changed["system.cable.diameter"].value == 0.03
    assert changed["system.cable.axial_stiffness"].value == named["system.cable.axial_stiffness"].value


def test_a_node_that_is_given_a_name_takes_the_values():
    taken = take_system(
        "winch_controller", ("cable.diameter", "cable.normal_drag"), given(system__cable="wire_28mm_6x36")
    )
    assert {name: value.value for name, value in taken.items()} == {"cable.diameter": 0.028}


def test_a_name_that_is_not_there_is_answered_with_the_nearest():
    with pytest.raises(ParameterError, match=r"f.yaml: /\*\*: system.cable: .*did you mean wire_28mm_6x36\?"):
        with_entries(given(system__cable="wire_28mm_6x63"))
    # a rope between two of the catalogue: 44 mm is nearer than 48, and 40 is spelt more like it
    with pytest.raises(ParameterError, match=r"did you mean wire_44mm_6x36\?"):
        with_entries(given(system__cable="wire_45mm_6x36"))
    for other_size in ("wire_99mm_6x36", "wire_29mm"):
        with pytest.raises(ParameterError, match="in the catalogue; heave list cable lists them"):
            find("cable", other_size)
    with pytest.raises(ParameterError, match="there is no winch 3 in the catalogue; heave list winch lists them"):
        with_entries(given(system__winch=3))
