"""A drive with a position loop of its own behind each way of a map, in the whole loop, beside one that goes by rate.

The drum is the first-order winch of thesis Eq. 6.1, u' = (u_0 - u)/T. The drive counts 0.1 mm, hauling in positive, and
begins at 12.3 m. Registers, nodes, datagrams and messages are as on the wire; the servers stand in memory.
"""

import functools
import socket
import struct
from types import SimpleNamespace

import pytest
from asyncua import ua
from heave_bringup import ClosedLoop, load_scenario, loop_parameters
from heave_devices.adapt import device as device_module
from heave_devices.adapt import orders as orders_module
from heave_devices.adapt.device import LiveDevice
from heave_devices.adapt.plc import modbus as modbus_module
from heave_devices.adapt.plc import opcua as opcua_module
from heave_devices.maps.device_map import device_map_of
from heave_msgs.msg import WinchCommand
from heave_node.files.bounded_yaml import parse_yaml
from sensor_msgs.msg import JointState

from tests.adapt_fakes import Node
from tests.plc import free_port

DT, COUNT, BEGAN = 0.05, 1e-4, 123_000
MAP = """
{source}
payout: {{{read}, unit: mm, scale: 0.1, positive: in, zero_at_start: true}}
payout_rate: {{{read_rate}, unit: mm/s, scale: 0.1, positive: in}}
command:
  {way}
  set: {{'{place}': {{quantity: payout, unit: mm, scale: 10.0, positive: in}}, '{enable}': enable}}
"""


class Polled:
    """A PLC that is asked: each order is written, and each tick read, by the exchange itself, without its thread."""

    def join(self, device):
        self.device, self.exchange = device, device.link._exchange
        self.exchange.open()
        device.link.put = self.exchange.write

    def show(self, position, speed):
        self.shown = position, speed
        self.device._on_sample(self.exchange.read())


class Modbus(Polled):
    map = MAP.format(
        source="source: {modbus: 127.0.0.1:502, word_order: little}",
        read="field: 'input:0:int32'",
        read_rate="field: 'input:2:int32'",
        way="timeout: 0.5",
        place="holding:0:int32",
        enable="holding:2.0",
    )

    def __init__(self, patch):
        self.read_coils = self.read_discrete_inputs = self.read_holding_registers = None
        patch.setattr(modbus_module, "ModbusTcpClient", lambda *_, **__: self)

    def connect(self):
        return True

    def read_input_registers(self, address, **_):
        position, speed = (struct.unpack("<HH", struct.pack("<i", number)) for number in self.shown)
        assert address == 0
        return SimpleNamespace(isError=lambda: False, registers=[*position, *speed])

    def write_registers(self, address, words, **_):
        assert address == 0
        self.order = struct.unpack("<iH", struct.pack("<HHH", *words))
        return SimpleNamespace(isError=lambda: False)


class OpcUa(Polled):
    map = MAP.format(
        source="source: {opcua: 'opc.tcp://127.0.0.1:4840/winch'}",
        read="field: 'ns=2;s=Position'",
        read_rate="field: 'ns=2;s=Speed'",
        way="timeout: 0.5",
        place="ns=2;s=SetPoint",
        enable="ns=2;s=Enable",
    )

    def __init__(self, patch):
        self.uaclient = self
        patch.setattr(opcua_module, "Client", lambda *_, **__: self)

    async def connect(self):
        pass

    def get_node(self, name):
        async def kind():
            return ua.VariantType.Boolean if name.Identifier == "Enable" else ua.VariantType.Int32

        return SimpleNamespace(read_data_type_as_variant_type=kind)

    async def read_attributes(self, *_):
        return [ua.DataValue(ua.Variant(number, ua.VariantType.Int32)) for number in self.shown]

    async def write_attributes(self, _, values):
        self.order = tuple(value.Value.Value for value in values)
        return [ua.StatusCode() for _ in values]


class Udp:
    def __init__(self, _):
        self.line = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.line.bind(("127.0.0.1", 0))
        self.line.settimeout(60.0)
        to = f"to: {{udp: '127.0.0.1:{self.line.getsockname()[1]}'}}\n  layout: {{place: int32, control: uint16}}"
        read = "format: datagram\nlayout: {position: int32, speed: int32}"
        self.map = MAP.format(
            source=f"source: {{udp: {free_port('udp')}}}\n{read}",
            read="field: position",
            read_rate="field: speed",
            way=to,
            place="place",
            enable="control.0",
        )

    def join(self, device):
        self.device = device

    def show(self, position, speed):
        self.device._on_bytes(struct.pack(">ii", position, speed), True)

    @property
    def order(self):
        return struct.unpack(">iH", self.line.recv(100))


class Ros2Control:
    map = MAP.format(
        source="",
        read="topic: /joint_states, type: sensor_msgs/msg/JointState, field: 'position[0]'",
        read_rate="topic: /joint_states, type: sensor_msgs/msg/JointState, field: 'velocity[0]'",
        way="topic: /commands\n  type: std_msgs/msg/Float64MultiArray",
        place="data[0]",
        enable="data[1]",
    )

    def __init__(self, _):
        pass

    def join(self, device):
        self.node = device._node

    def show(self, position, speed):
        self.node.callbacks["/joint_states"](JointState(position=[float(position)], velocity=[float(speed)]))

    @property
    def order(self):
        return self.node.sent["/commands"][-1].data


def loop(lag, *settings):
    own = ["winch_controller.law=lqg", "all.duration=180", f"winch_controller.winch.time_constant={lag}", *settings]
    return ClosedLoop(loop_parameters(load_scenario("b2_calm_300", settings=own)))


@functools.cache
def by_rate(lag):
    """Return the residual of a drive that goes by rate, and that of a locked winch [m]."""
    record = loop(lag, f"virtual_winch.time_constant={lag}").run()
    return record.unit_sigma(after=90.0), record.uncompensated_sigma(after=90.0)


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "lag"), [(Modbus, 0.35), (OpcUa, 1.0), (Udp, 0.35), (Ros2Control, 1.0)])
def test_a_drive_that_goes_by_payout_compensates_as_one_that_goes_by_rate(kind, lag, monkeypatch):
    closed = loop(lag, "virtual_winch.law=first_order", f"virtual_winch.position_rate={1.0 / lag}")
    wall = SimpleNamespace(monotonic=lambda: 100.0 + DT * closed.tick)
    wall.time_ns = wall.monotonic_ns = lambda: round(wall.monotonic() * 1e9)
    for module in (device_module, orders_module):
        monkeypatch.setattr(module, "time", wall)
    node, plc, step = Node(), kind(monkeypatch), closed.winch.step
    device = LiveDevice(device_map_of("winch", parse_yaml(plc.map)), node)
    plc.join(device)
    plc.show(BEGAN, 0)

    def through_the_plc(tick, command, tension):
        asked = WinchCommand(sequence=tick, payout=command.payout, payout_rate=command.payout_rate, brake=command.brake)
        node.callbacks["winch/command"](asked)
        place, enable = plc.order
        order = command._replace(payout=-COUNT * (place - BEGAN), payout_rate=0.0, brake=not enable)
        state = step(tick, order, tension)
        plc.show(BEGAN - round(state.payout / COUNT), -round(state.payout_rate / COUNT))
        read = node.sent["winch/state"][-1]
        closed.winch.state = state._replace(
            encoder_payout=read.encoder_payout, encoder_payout_rate=read.encoder_payout_rate
        )
        return closed.winch.state

    closed.winch.step = through_the_plc
    residual, uncompensated = by_rate(lag)
    assert residual < 0.05 * uncompensated
    assert closed.run().unit_sigma(after=90.0) == pytest.approx(residual, rel=0.1)
    assert not device.orders.handshake.fault
    device.close()
