"""The loop in one process reads what the loop over messages reads, to the last bit, whatever the parameters."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable

import numpy as np
import pytest
from cable_sim_node.component import CableSim
from cable_sim_node.conversions import (
    DRUM_MOTION,
    POINT_MOTION,
    WINCH_COMMAND,
    drum_motion_of,
    point_motion_of,
    winch_command_of,
    winch_state_message,
)
from cable_sim_node.node_parameters import CableSimNodeParameters
from cable_sim_node.sensors.instruments import SensorsParameters
from cable_sim_node.winch.component import VirtualWinch
from cable_sim_node.winch.parameters import WinchParameters
from heave_bags.analyse import kpi_set
from heave_bringup.closed_loop import ClosedLoop, LoopParameters, LoopRecord, loop_parameters
from heave_bringup.run.loop_signals import run_signals
from heave_bringup.scenarios import load_scenario, make_scenario
from heave_node.crane.pose import POSE_FIELDS, pose_message, pose_of, pose_to_wire
from heave_node.interface import topics
from heave_node.interface.fault_kinds import FAULTS, LARGEST_DELAY, faults_of
from heave_node.interface.messages import MessageReader, SensorMessages
from heave_node.interface.sensors import MRU, SENSORS, STANDARD_WATER, Water, WireReading, all_to_wire
from heave_node.interface.topic import Topic
from heave_node.parameters import ParameterInfo, describe
from heave_node.tick.tick import Tick
from hypothesis import example, given, settings
from hypothesis import strategies as st
from wave_vessel_node.component import WaveVessel
from wave_vessel_node.conversions import boom_tip_message
from wave_vessel_node.parameters import WaveVesselParameters
from winch_controller_node.core.component import WinchController
from winch_controller_node.in_front import motion_source
from winch_controller_node.interface.conversions import WINCH_STATE, command_message, measurements, winch_reading_of
from winch_controller_node.interface.readings import Measurements, Outputs
from winch_controller_node.interface.sensors import INPUTS, SCALAR_SENSORS
from winch_controller_node.node_parameters import WinchControllerParameters

DURATION = 3.0


def heard(topic: Topic, fields: tuple[str, ...], data: bytes) -> WireReading:
    """Return the reading that a node has of a message."""
    return MessageReader(topic.type, fields).reading(data)


class LoopOverMessages:
    """The loop as the nodes do it: every hand-over is the bytes of a message, made and read by the nodes' functions."""

    def __init__(self, p: LoopParameters) -> None:
        self.dt = p.tick_period
        self.sea = WaveVessel(p.sea, seed=p.seed, tick_period=self.dt)
        self.plant = CableSim(p.plant, seed=p.seed, tick_period=self.dt)
        self.winch = VirtualWinch(p.winch, tick_period=self.dt)
        self.controller = WinchController(p.controller, tick_period=self.dt, seed=p.seed)
        self.source = motion_source(self.controller, self.dt)
        self.water = Water(p.controller.water_density, p.controller.gravity)
        self.messages = {name: SensorMessages(sensor) for name, sensor in SENSORS.items()}
        self.winch_state: bytes | None = None

    def step(self, number: int) -> tuple[Measurements, Outputs, tuple[float, ...]]:
        tick = Tick(number, 1, round(self.dt * 1e9))
        state, readings = self.plant.readings(number)
        vessel = self.sea.step(number)
        on_wire = all_to_wire(readings, self.plant.water)
        on_wire["mru"] = [MRU.to_wire(vessel.mru, STANDARD_WATER)] if vessel.mru is not None else []
        delivered = {
            name: [messages.reading(messages.message(reading)) for reading in on_wire.get(name, [])]
            for name, messages in self.messages.items()
            if name in INPUTS
        }
        winch = self.winch_state
        reading = winch_reading_of(heard(topics.WINCH_STATE, WINCH_STATE, winch)) if winch is not None else None
        poses = [pose_message(pose_to_wire(pose)) for pose in vessel.crane]
        crane = [pose_of(heard(topics.CRANE_POSE, POSE_FIELDS, pose)) for pose in poses]
        taken = measurements(delivered, reading, self.water)
        outputs = self.source.step(number, taken, crane)
        ordered = command_message(outputs.order, tick.start_nanoseconds)
        command = winch_command_of(heard(topics.WINCH_COMMAND, WINCH_COMMAND, ordered))
        row = (state.unit.position[2], self.winch.state.payout, self.winch.state.payout_rate, state.top_tension)
        reached = self.winch.step(number, command, state.top_tension)
        self.winch_state = winch_state_message(reached, tick.end_nanoseconds)
        drum = drum_motion_of(heard(topics.WINCH_STATE, DRUM_MOTION, self.winch_state))
        moved = boom_tip_message(vessel.boom_tip, tick.end_nanoseconds)
        tip = point_motion_of(heard(topics.BOOM_TIP, POINT_MOTION, moved))
        self.plant.advance(
            number, tip, (float(drum.position[0]), float(drum.velocity[0])), outputs.report.depth_set_point
        )
        return taken, outputs, row


def compare(p: LoopParameters) -> None:
    """Run both loops and compare what the controller is given, what it orders, where the unit goes, and the KPIs."""
    loop, over_messages = ClosedLoop(p), LoopOverMessages(p)
    given_to: list[Measurements] = []
    step = loop.controller.step

    def watched(tick: int, taken: Measurements) -> Outputs:
        given_to.append(taken)
        return step(tick, taken)

    loop.controller.step = watched
    rows, others = [], []
    for number in range(1, round(p.duration / p.tick_period) + 1):
        outputs, row = loop.step()
        taken, other, reached = over_messages.step(number)
        assert outputs.order == other.order
        np.testing.assert_equal(dataclasses.asdict(given_to[-1]), dataclasses.asdict(taken))
        np.testing.assert_equal(outputs.report._asdict(), other.report._asdict())
        rows.append(row)
        others.append(row.copy())
        others[-1][[2, 4, 5, 7]] = reached
    one, two = (run_signals(LoopRecord(np.array(r)), p) for r in (rows, others))
    np.testing.assert_equal(kpi_set.evaluate(one, 1.0, DURATION), kpi_set.evaluate(two, 1.0, DURATION))


def number_in(info: ParameterInfo) -> st.SearchStrategy[object]:
    """Draw any legal value of a parameter, to a millionth."""
    if info.choices:
        one: st.SearchStrategy[object] = st.sampled_from(info.choices)
    elif info.type is bool:
        one = st.booleans()
    else:
        one = st.floats(info.minimum, info.maximum).map(lambda value: max(round(value, 6), info.minimum))
    return st.lists(one, min_size=info.length, max_size=info.length) if info.length else one


@st.composite
def faults(draw: st.DrawFn, prefix: str, device: str) -> dict[str, object]:
    """Draw up to two faults of a device in the first seconds."""
    kinds = draw(st.lists(st.sampled_from(faults_of(device)), max_size=2))
    largest = min(LARGEST_DELAY.get(device, 2.0), 2.0)
    columns = {
        "kind": kinds,
        "start": [draw(st.floats(0.0, DURATION)) for _ in kinds],
        "duration": [draw(st.floats(0.0, 2.0)) for _ in kinds],
        "magnitude": [draw(st.floats(0.1, largest)) if FAULTS[kind].magnitude else 0.0 for kind in kinds],
    }
    return {f"{prefix}faults.{name}": values for name, values in columns.items()}


def drawn(draw: st.DrawFn, infos: Iterable[ParameterInfo], *beginnings: str) -> dict[str, object]:
    """Draw some of the parameters whose names begin so, faults apart."""
    found = [info for info in infos if info.name.startswith(beginnings) and "faults" not in info.name]
    chosen = draw(st.lists(st.sampled_from(found), unique_by=lambda info: info.name, max_size=6))
    return {info.name: draw(number_in(info)) for info in chosen}


PLANT = describe(CableSimNodeParameters)
SENSORS_OF_PLANT = tuple(SensorsParameters().by_name())


@st.composite
def legal(draw: st.DrawFn) -> dict[str, dict[str, object]]:
    """Draw any legal parameters of what is measured and how it travels, of plant and belief apart."""
    plant: dict[str, object] = drawn(draw, PLANT, "sensors.", "water_density", "gravity")
    for name in SENSORS_OF_PLANT:
        plant |= draw(faults(f"sensors.{name}.", "sensor"))
    controller = drawn(draw, describe(WinchControllerParameters), "water_density", "gravity", "health.spike")
    others = draw(st.lists(st.sampled_from([name for name in SCALAR_SENSORS if name != "depth"]), unique=True))
    return {
        "wave_vessel": drawn(draw, describe(WaveVesselParameters), "mru.") | draw(faults("mru.", "mru")),
        "cable_sim": plant,
        "virtual_winch": drawn(draw, describe(WinchParameters), "encoder.", "command_delay")
        | draw(faults("encoder.", "encoder"))
        | draw(faults("", "winch")),
        "winch_controller": controller | {"sensors.use": ["mru", "depth", "encoder", *others]},
    }


def parameters(drawn_values: dict[str, dict[str, object]], tick_period: float, seed: int) -> LoopParameters:
    base = {
        "wave_vessel": {"significant_wave_height": 1.5, "peak_period": 10.0, "ramp": 1.0},
        "cable_sim": {"model": "linear", "length": 900.0, "linear.inertia": 7.34, "linear.damping": 0.19},
        "virtual_winch": {},
        "winch_controller": {
            "law": "lqg",
            "length": 900.0,
            "cable_model.inertia": 7.34,
            "cable_model.damping": 0.19,
            "modes.settling_time": 1.0,
            "modes.fade_in_time": 1.0,
        },
    }
    values = {node: base[node] | drawn_values.get(node, {}) for node in base}
    values["/**"] = {"seed": seed, "duration": DURATION, "tick_period": tick_period}
    return loop_parameters(make_scenario(values))


@settings(max_examples=8)
@given(values=legal(), tick_period=st.sampled_from([0.05, 0.1, 1.0 / 30.0, 0.0373]), seed=st.integers(0, 2**31 - 1))
@example(values={"cable_sim": {"water_density": 1030.0}}, tick_period=0.05, seed=1)
@example(
    values={"cable_sim": {"gravity": 9.83}, "winch_controller": {"sensors.use": ["mru", "depth", "encoder", "imu"]}},
    tick_period=0.05,
    seed=1,
)
@example(values={"winch_controller": {"water_density": 0.0}}, tick_period=0.05, seed=1)
def test_both_loops_give_equal_readings_and_equal_figures_for_any_legal_parameters(values, tick_period, seed):
    compare(parameters(values, tick_period, seed))


def test_a_depth_is_read_by_the_density_that_the_controller_believes_in_also_without_ros():
    """300 m under 1030 kg/m^3, read with 1025 assumed: 301.46 m."""
    p = parameters({"cable_sim": {"length": 300.0, "water_density": 1030.0, "sensors.depth.noise": 0.0}}, 0.05, 1)
    loop, depths = ClosedLoop(p), {}
    for _ in range(10):
        _, row = loop.step()
        depths[round(row[0], 6)] = -row[2]
    # the first sample is of 0.1 s
    assert loop.controller.observer.depth_zero == pytest.approx(depths[0.1] * 1030.0 / 1025.0, abs=1e-9)
    assert depths[0.1] == pytest.approx(300.0, abs=1.0)


@pytest.mark.parametrize("assumed", [9.83, 9.80665])
def test_gravity_of_the_place_is_in_what_an_imu_says_and_the_one_believed_in_is_taken_off(assumed):
    quiet = {"sensors.imu.noise": 0.0}
    values = {"cable_sim": {"gravity": 9.83} | quiet, "winch_controller": {"gravity": assumed}}
    loop = ClosedLoop(parameters(values, 0.05, 1))
    heard = []
    step = loop.controller.step
    loop.controller.step = lambda tick, taken: heard.append(taken) or step(tick, taken)
    loop.step()
    # the unit hangs at rest in the first tick
    assert heard[0].of("imu")[0].value == pytest.approx(9.83 - assumed, abs=1e-9)


def test_a_slow_late_depth_sensor_is_compared_with_where_the_unit_was():
    """1 Hz, 10 cm, and 1 s late, as stated: it is no contradiction of the motion reference unit."""
    given_settings = [f"system.sensors.depth.{name}" for name in ("rate=1", "noise=0.1", "latency=1.0")]
    scenario = load_scenario("module_900", settings=["all.duration=45", *given_settings])
    record = ClosedLoop(loop_parameters(scenario)).run()
    assert "DEPTH_MRU_DISAGREE" not in {alarm.name for _, alarm in record.alarms}
    assert record.modes[-1] == "compensating"
