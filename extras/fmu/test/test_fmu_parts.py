"""The parts of FMUs, wired by the names of their variables, are the loop of `heave_bringup.closed_loop`."""

import numpy as np
import pytest
from heave_bringup.closed_loop import COLUMNS, ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario
from heave_fmu.export import connections, make_parts
from heave_fmu.part import STEPS
from heave_fmu.ports import Port
from heave_fmu.variables import REAL, UNITS
from heave_node.errors import NodeError
from heave_node.interface import topics
from heave_node.interface.sensors import WireReading
from heave_node.parameters import ParameterError

ORDER = ("controller", "winch", "vessel", "plant")
SHORT = ("all.duration=16", "all.transient=8")
EVERY_SENSOR = ("cable_sim.sensors.usbl.fitted=true", "cable_sim.sensors.velocity.fitted=true")
LATE = (
    "cable_sim.sensors.depth.faults.kind=[delay]",
    "cable_sim.sensors.depth.faults.start=[5.0]",
    "cable_sim.sensors.depth.faults.duration=[4.0]",
    "cable_sim.sensors.depth.faults.magnitude=[0.32]",
)
CASES = [
    ("b2_calm_300", (*EVERY_SENSOR, *LATE)),
    ("b11_splash_zone", ()),
    ("drive_electric_900", ()),
]


def rows_of_parts(scenario, *, together: bool):
    """Return what is known of the loop at each tick: stepped one by one, or together."""
    parts = make_parts(scenario, ORDER)
    wires = [(parts[source].outputs, parts[target].inputs, variable) for variable, source, target in connections(parts)]
    places = [(_place(outputs, name), _place(inputs, name)) for outputs, inputs, name in wires]
    for part in parts.values():
        part.start()

    def carry():
        for (source, index), (target, own) in places:
            target.values[own] = source.values[index]

    rows = []
    for tick in range(1, round(scenario.run.duration / scenario.run.tick_period) + 1):
        for step in range(STEPS):
            carry()
            for part in parts.values():
                if int(part.instant * STEPS) == step:
                    part.step(tick)
                    if not together:
                        carry()
            if step == 0:
                rows.append([_value(parts, name) for name in ("unit", "payout", "authority", "top_tension")])
    return np.array(rows)


def _place(ports, name):
    for port in ports.values():
        for index, variable in enumerate(port.variables):
            if variable.name == name:
                return port, index
    raise AssertionError(name)


def _value(parts, name):
    part, variable = {
        "unit": ("plant", "unit.odometry.pose.pose.position.z"),
        "payout": ("winch", "winch.state.payout"),
        "authority": ("controller", "controller.state.authority"),
        "top_tension": ("plant", "cable.state.top_tension"),
    }[name]
    port, index = _place(parts[part].outputs, variable)
    return port.values[index]


@pytest.mark.parametrize("together", [True, False])
@pytest.mark.parametrize(("name", "settings"), CASES)
def test_parts_wired_by_their_names_are_the_closed_loop_to_the_last_bit(name, settings, together):
    scenario = load_scenario(name, settings=[*SHORT, *settings])
    parameters = loop_parameters(scenario)
    expected = ClosedLoop(parameters).run().rows
    columns = [COLUMNS.index(column) for column in ("unit", "payout", "authority", "top_tension")]
    np.testing.assert_array_equal(rows_of_parts(scenario, together=together), expected[:, columns])


@pytest.mark.parametrize(("name", "settings"), [("crane_slew", ()), ("b2_calm_300", ("wave_vessel.preview.time=4",))])
def test_what_has_no_variables_is_refused(name, settings):
    with pytest.raises(ParameterError, match="have no variables"):
        make_parts(load_scenario(name, settings=settings))


def test_variables_have_the_names_and_units_of_the_messages():
    parts = make_parts(load_scenario("b2_calm_300", settings=EVERY_SENSOR))
    ports = [port for part in parts.values() for port in (*part.inputs.values(), *part.outputs.values())]
    units = {variable.name: variable.unit for port in ports for variable in port.variables}
    assert {variable.unit for port in ports for variable in port.variables} - {""} <= set(UNITS)
    assert units["winch.command.payout_rate"] == "m/s"
    assert units["boom_tip.acceleration.z"] == "m/s^2"
    assert units["unit.pressure.fluid_pressure"] == "Pa"
    assert units["winch.state.power"] == "W"
    assert units["unit.usbl[2].pose.pose.position.x"] == "m"
    without = {
        variable.name
        for port in ports
        for variable in port.variables
        if variable.kind == REAL and not variable.unit and variable.name.rpartition(".")[2] != "authority"
    }
    assert without == set()


def test_a_message_is_taken_once_and_none_is_lost_in_silence():
    port = Port(topics.WAVE_ELEVATION, ("elevation",), slots=2)
    port.publish([WireReading(50_000_000, (1.0,)), WireReading(100_000_000, (2.0,))])
    assert port.take(now=0) == [WireReading(50_000_000, (1.0,)), WireReading(100_000_000, (2.0,))]
    assert port.take(now=0) == []
    port.values[0] += 3
    with pytest.raises(NodeError, match="3 messages came in one tick, 2 have variables"):
        port.take(now=0)
    with pytest.raises(NodeError, match="more than 2 messages"):
        port.publish([WireReading(0, (0.0,))] * 3)


def test_an_input_whose_messages_nobody_counts_brings_one_with_each_tick_stamped_with_the_tick():
    port = Port(topics.WAVE_ELEVATION, ("elevation",))
    port.await_messages()
    port.values[2] = 1.5
    assert [port.take(now=7), port.take(now=8)] == [[WireReading(7, (1.5,))], [WireReading(8, (1.5,))]]
