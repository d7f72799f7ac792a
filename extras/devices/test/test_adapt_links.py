"""The ways to a device: a pseudo-terminal for a serial port, and UDP and TCP on loopback."""

import os
import pty
import socket
import time
import tty
from contextlib import ExitStack

import pytest
import serial
from heave_bringup.errors import CommandError
from heave_devices.adapt.links import LinkReader
from heave_devices.maps.link import Link

from tests.plc import free_port


class Heard:
    def __init__(self):
        self.data, self.is_whole = b"", []

    def __call__(self, data, is_whole):
        self.data += data
        self.is_whole.append(is_whole)

    def wait_for(self, wanted):
        wait_until(lambda: wanted in self.data)


def wait_until(condition):
    deadline = time.monotonic() + 20.0
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.01)


@pytest.fixture
def reader_of():
    readers = []

    def make(link):
        heard = Heard()
        reader = LinkReader(link, heard)
        readers.append(reader)
        reader.start()
        return reader, heard

    yield make
    for reader in readers:
        reader.close()


def test_a_serial_line_is_read_and_written(reader_of):
    device, name = pty.openpty()
    tty.setraw(name)
    reader, heard = reader_of(Link("serial", os.ttyname(name), 9600))
    os.write(device, b"$PSXN,23,0.30,-0.97")
    os.write(device, b",298.57,0.13*1B\r\n")
    heard.wait_for(b"1B\r\n")
    assert not any(heard.is_whole), "a stream has no ends"
    reader.send(b"$STOP\r\n")
    assert os.read(device, 100) == b"$STOP\r\n"
    os.close(device)
    os.close(name)


def test_a_datagram_is_whole_and_is_answered_where_it_came_from(reader_of):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as device:
        device.bind(("127.0.0.1", 0))
        device.settimeout(10.0)
        port = free_port("udp")
        reader, heard = reader_of(Link("udp", "127.0.0.1", port))
        device.sendto(b"one", ("127.0.0.1", port))
        heard.wait_for(b"one")
        assert heard.is_whole == [True]
        reader.send(b"back")
        assert device.recv(100) == b"back"


def test_what_cannot_be_processed_ends_no_thread_and_is_named_once():
    failing = {"left": 2}

    def process(data, _):
        heard(data, True)
        if failing["left"]:
            failing["left"] -= 1
            raise OverflowError("cannot convert float infinity to integer")

    heard = Heard()
    port = free_port("udp")
    reader = LinkReader(Link("udp", "127.0.0.1", port), process)
    reader.start()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as device:
        deadline = time.monotonic() + 20.0
        while b"four" not in heard.data:
            assert time.monotonic() < deadline
            if failing["left"] == 0:
                device.sendto(b"four", ("127.0.0.1", port))
            else:
                device.sendto(b"two.", ("127.0.0.1", port))
            time.sleep(0.05)
    reader.close()
    assert reader.failures == 2
    assert reader.failed.startswith("OverflowError: cannot convert float infinity to integer.")


def test_a_map_may_name_the_one_sender_that_is_heard(reader_of):
    """127.0.0.2 is another host as far as its address says."""
    port = free_port("udp")
    reader, heard = reader_of(Link("udp", "127.0.0.1", port, sender="127.0.0.2"))
    with ExitStack() as stack:
        stranger, device = (stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) for _ in range(2))
        device.bind(("127.0.0.2", 0))
        stranger.sendto(b"stranger", ("127.0.0.1", port))
        device.sendto(b"device", ("127.0.0.1", port))
        heard.wait_for(b"device")
    assert heard.data == b"device"
    assert reader.strangers == 1


def test_a_second_sender_is_counted_where_the_map_names_none(reader_of):
    port = free_port("udp")
    reader, heard = reader_of(Link("udp", "127.0.0.1", port))
    with ExitStack() as stack:
        first, second = (stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) for _ in range(2))
        second.bind(("127.0.0.2", 0))
        first.sendto(b"one", ("127.0.0.1", port))
        heard.wait_for(b"one")
        assert reader.strangers == 0
        second.sendto(b"two", ("127.0.0.1", port))
        heard.wait_for(b"two")
    assert reader.strangers == 1


def test_a_tcp_device_may_come_late_leave_and_come_again(reader_of):
    port = free_port("tcp")
    reader, heard = reader_of(Link("tcp", "127.0.0.1", port))
    wait_until(lambda: reader.problem)
    with socket.create_server(("127.0.0.1", port)) as server:
        server.settimeout(20.0)
        for text in (b"first", b"second"):
            connection, _ = server.accept()
            connection.sendall(text)
            heard.wait_for(text)
            assert not reader.problem
            connection.close()
    assert reader.opened == 2


def test_what_cannot_be_opened_is_refused_in_one_line():
    with pytest.raises(CommandError, match=r"serial /dev/none at 9600: cannot be opened: No such file"):
        LinkReader(Link("serial", "/dev/none", 9600), Heard())
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        port = taken.getsockname()[1]
        with pytest.raises(CommandError, match="Address already in use"):
            LinkReader(Link("udp", "127.0.0.1", port), Heard())


def test_a_sender_sends_datagrams_where_the_map_says():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as winch:
        winch.bind(("127.0.0.1", 0))
        winch.settimeout(10.0)
        out = LinkReader(Link("udp", "127.0.0.1", winch.getsockname()[1]), None)
        out.send(b"$W,1\r\n")
        assert winch.recv(100) == b"$W,1\r\n"
        out.close()


def test_a_serial_port_that_is_pulled_is_told_in_one_sentence(reader_of, monkeypatch):
    """pyserial says that the device reports readiness to read but returned no data."""

    def pulled(*_):
        raise serial.SerialException(
            "device reports readiness to read but returned no data (device disconnected or multiple access on port?)"
        )

    master, slave = pty.openpty()
    tty.setraw(slave)
    monkeypatch.setattr(serial.Serial, "read", pulled)
    reader, _ = reader_of(Link("serial", os.ttyname(slave), 9600))
    wait_until(lambda: reader.problem)
    assert reader.problem.startswith("the port is gone: its cable was pulled")
    os.close(master)
    os.close(slave)
