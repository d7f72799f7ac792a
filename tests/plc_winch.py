"""A winch behind a PLC: `python plc_winch.py modbus|opcua|udp PORT [...]`, until it is ended.

It knows nothing of the suite. The PLC's program runs every 10 ms. Drum: a dead time, then a first-order lag of the
speed, a limit of speed and of acceleration. Counts of 0.1 mm, positive hauls in. Its watchdog: where the counter that
it is sent has not changed for 0.5 s the drum stops and brakes, and a fault is latched, until `enable` is off and
`reset` is on.

Words on its standard input: `halt` (the program stands, the server still answers), `go`, `refuse` (the server answers
each request with an exception), `accept`, `trip` (the drive trips), `restart` (its count and its clock
begin at 0), `anew` (all is as at its start, and is said to be so), `where` (it prints its greatest speed since the
last time, the place of its drum, and whether it is enabled), `end`. It prints `ready` once it can be reached.
"""

import argparse
import asyncio
import random
import struct
import sys
import time
import zlib

from asyncua import Server, ua
from pymodbus.constants import ExcCodes
from pymodbus.server import ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice

SCAN, WATCHDOG, COUNT = 0.01, 0.5, 1e-4
LAG, SPEED, ACCELERATION = 0.15, 2.0, 1.5
STATE, ORDER = ">HIIiiiH", ">HIIiH"
STATE_MARK, ORDER_MARK = 0x5753, 0x574F
ENABLE, RESET = 1, 2
BRAKE, FAULT = 1, 2


class Plc:
    """The program and the drum."""

    def __init__(self, dead_time, speed_limit=SPEED):
        self.dead_time, self.speed_limit = dead_time, speed_limit
        self.begin_anew()

    def begin_anew(self):
        self.position = self.speed = 0.0  # [m], [m/s], positive hauls in
        self.order, self.control, self.counter = 0, 0, -1
        self.heard = time.monotonic()
        self.under_way = []
        self.wanted = 0.0
        self.fault = False
        self.is_halted = self.refuses = False
        self.cycles = 0
        self.fastest = 0.0
        self.newest = None  # number of the newest datagram
        self.restart()

    def restart(self):
        self.counted_from, self.began = self.position, time.monotonic()

    @property
    def milliseconds(self):
        return round(1e3 * (time.monotonic() - self.began)) % 2**32

    def take(self, order, control, counter):
        if counter != self.counter and not self.is_halted:
            self.heard, self.counter = time.monotonic(), counter
        self.order, self.control = order, control

    def scan(self, step):
        now = time.monotonic()
        if not self.is_halted:
            self.cycles += 1
            is_alone = now - self.heard > WATCHDOG
            if is_alone and self.control & ENABLE:
                self.fault = True
            if self.fault and not is_alone and self.control & RESET and not self.control & ENABLE:
                self.fault = False
            self.under_way.append((now + self.dead_time, self.order * COUNT))
        while self.under_way and self.under_way[0][0] <= now:
            self.wanted = self.under_way.pop(0)[1]
        stops = self.is_halted or self.fault or not self.control & ENABLE
        goal = 0.0 if stops else min(max(self.wanted, -self.speed_limit), self.speed_limit)
        change = (goal - self.speed) * (1.0 if stops else min(step / LAG, 1.0))
        self.speed += min(max(change, -ACCELERATION * step), ACCELERATION * step)
        self.position += self.speed * step
        self.fastest = max(self.fastest, abs(self.speed))

    @property
    def counts(self):
        return round((self.position - self.counted_from) / COUNT), round(self.speed / COUNT)

    @property
    def status(self):
        braked = self.speed == 0.0 and (self.is_halted or self.fault or not self.control & ENABLE)
        return braked * BRAKE | self.fault * FAULT


def words(value):
    return [value >> 16 & 0xFFFF, value & 0xFFFF]


def signed(pair):
    return struct.unpack(">i", struct.pack(">HH", *pair))[0]


async def modbus(plc, options):
    async def access(function, start, address, count, registers, new):
        del count, address
        if plc.refuses:
            return ExcCodes.DEVICE_FAILURE
        if function == 4:
            position, speed = plc.counts
            registers[-start : 10 - start] = [
                *words(position),
                *words(speed),
                plc.status,
                plc.cycles & 0xFFFF,
                *words(2500),
                *words(plc.milliseconds),
            ]
        if new is not None:
            plc.take(signed(new[0:2]), new[2], new[3])
        return None

    one = [SimData(0, values=False, datatype=DataType.BITS)]
    table = [SimData(0, values=[0] * 10, datatype=DataType.REGISTERS)]
    orders = [SimData(0, values=[0] * 4, datatype=DataType.REGISTERS)]
    device = SimDevice(1, simdata=(one, one, orders, table), action=access)
    server = ModbusTcpServer(device, address=("127.0.0.1", options.port))
    await server.serve_forever(background=True)


async def opcua(plc, options):
    server = Server()
    await server.init()
    server.set_endpoint(f"opc.tcp://127.0.0.1:{options.port}/winch")
    server.set_security_policy([ua.SecurityPolicyType.NoSecurity])
    space = await server.register_namespace("urn:winch")
    folder = await server.nodes.objects.add_object(ua.NodeId("Winch", space), "Winch")

    async def variable(name, value, kind):
        node = await folder.add_variable(ua.NodeId(f"Winch.{name}", space), name, value, kind)
        await node.set_writable()
        return node

    shown = {
        "Position": await variable("Position", 0, ua.VariantType.Int32),
        "Speed": await variable("Speed", 0.0, ua.VariantType.Double),
        "Pull": await variable("Pull", 25.0, ua.VariantType.Float),
        "Brake": await variable("Brake", True, ua.VariantType.Boolean),
        "Fault": await variable("Fault", False, ua.VariantType.Boolean),
        "Counter": await variable("Counter", 0, ua.VariantType.UInt16),
    }
    asked = {
        "SpeedSetpoint": await variable("SpeedSetpoint", 0.0, ua.VariantType.Float),
        "Enable": await variable("Enable", False, ua.VariantType.Boolean),
        "Reset": await variable("Reset", False, ua.VariantType.Boolean),
        "CounterIn": await variable("CounterIn", 0, ua.VariantType.UInt16),
    }
    await server.start()

    async def exchange():
        while True:
            position, _ = plc.counts
            new = [position, plc.speed, 25.0, bool(plc.status & BRAKE), plc.fault, plc.cycles & 0xFFFF]
            for (name, node), value in zip(shown.items(), new, strict=True):
                kinds = {"Position": "Int32", "Speed": "Double", "Pull": "Float", "Counter": "UInt16"}
                kind = getattr(ua.VariantType, kinds.get(name, "Boolean"))
                status = ua.StatusCode(ua.StatusCodes.BadDeviceFailure if plc.refuses else ua.StatusCodes.Good)
                await node.write_value(ua.DataValue(ua.Variant(value, kind), status))
            speed, enable, reset, counter = [await node.read_value() for node in asked.values()]
            plc.take(round(speed / COUNT), enable * ENABLE | reset * RESET, counter)
            await asyncio.sleep(SCAN)

    options.tasks.append(asyncio.create_task(exchange()))


class Line(asyncio.DatagramProtocol):
    """Datagrams both ways, some of them lost, late, twice or broken."""

    def __init__(self, plc, options):
        self.plc, self.options = plc, options
        self.random = random.Random(options.seed)
        self.number = 0

    def connection_made(self, transport):
        self.transport = transport

    def spoil(self, data, deliver):
        draw, o = self.random.random, self.options
        if draw() < o.lost:
            return
        if draw() < o.broken:
            place = self.random.randrange(len(data))
            data = data[:place] + bytes([data[place] ^ 1 << self.random.randrange(8)]) + data[place + 1 :]
        for _ in range(1 + (draw() < o.double)):
            delay = o.delay * draw() + (0.08 * draw() if draw() < o.late else 0.0)
            asyncio.get_running_loop().call_later(delay, deliver, data)

    def datagram_received(self, data, peer):
        self.spoil(data, self.taken)

    def taken(self, data):
        if len(data) != struct.calcsize(ORDER) + 4 or struct.pack(">I", zlib.crc32(data[:-4])) != data[-4:]:
            return
        mark, sequence, _, order, control = struct.unpack(ORDER, data[:-4])
        is_alone = time.monotonic() - self.plc.heard > WATCHDOG  # then the sender may have restarted
        newest = self.plc.newest
        is_newer = newest is None or is_alone or 0 < (sequence - newest) % 2**32 < 2**31
        if mark != ORDER_MARK or not is_newer:
            return
        self.plc.newest = sequence
        self.plc.take(order, control, sequence)

    async def speak(self):
        while True:
            if not (self.plc.refuses or self.plc.is_halted):
                self.number += 1
                plc = self.plc
                body = struct.pack(STATE, STATE_MARK, self.number, plc.milliseconds, *plc.counts, 2500, plc.status)
                data = body + struct.pack(">I", zlib.crc32(body))
                self.spoil(data, lambda d: self.transport.sendto(d, ("127.0.0.1", self.options.to)))
            await asyncio.sleep(0.02)


async def udp(plc, options):
    loop = asyncio.get_running_loop()
    _, line = await loop.create_datagram_endpoint(lambda: Line(plc, options), local_addr=("127.0.0.1", options.port))
    options.tasks.append(asyncio.create_task(line.speak()))


async def run(options):
    plc = Plc(options.dead_time, options.speed)
    options.tasks = []
    await {"modbus": modbus, "opcua": opcua, "udp": udp}[options.kind](plc, options)

    def obey():
        word = sys.stdin.readline().strip()
        if word in ("halt", "go"):
            plc.is_halted = word == "halt"
        elif word in ("refuse", "accept"):
            plc.refuses = word == "refuse"
        elif word == "trip":
            plc.fault = True
        elif word == "restart":
            plc.restart()
        elif word == "anew":
            plc.begin_anew()
            sys.stdout.write("ready\n")
            sys.stdout.flush()
        elif word == "where":
            enable = plc.control & ENABLE
            sys.stdout.write(f"fastest {plc.fastest:.4f} position {plc.position:.5f} enable {enable}\n")
            sys.stdout.flush()
            plc.fastest = 0.0
        elif word in ("", "end"):
            options.ended.set()

    options.ended = asyncio.Event()
    asyncio.get_running_loop().add_reader(sys.stdin, obey)
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    last = time.monotonic()
    while not options.ended.is_set():
        await asyncio.sleep(SCAN)
        now = time.monotonic()
        plc.scan(now - last)
        last = now


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("kind", choices=("modbus", "opcua", "udp"))
    parser.add_argument("port", type=int)
    parser.add_argument("--to", type=int, help="udp: port that the state is sent to")
    parser.add_argument("--dead-time", type=float, default=0.2)
    parser.add_argument("--speed", type=float, default=SPEED)
    for name in ("lost", "double", "late", "broken", "delay"):
        parser.add_argument(f"--{name}", type=float, default=0.0)
    parser.add_argument("--seed", type=int, default=1)
    asyncio.run(run(parser.parse_args()))


if __name__ == "__main__":
    main()
