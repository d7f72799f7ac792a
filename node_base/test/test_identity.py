"""What can be said of the machine of a process by the identifier of its publishers."""

import os

import pytest
from heave_node.ros.transport.identity import host_of, place_of


def prefix(host: int, process: int) -> str:
    """Return the first 12 bytes of a GID of Fast DDS: vendor, host, process, random number, participant."""
    return (bytes([1, 15]) + host.to_bytes(2, "big") + process.to_bytes(4, "little") + bytes([7, 7, 0, 0])).hex()


HERE = prefix(0xA1B2, os.getpid() & 0xFFFF)


def test_a_process_of_this_machine_is_told_with_its_number_while_it_lives():
    assert place_of(HERE, HERE) == f"process {os.getpid() & 0xFFFF} on this machine"
    assert place_of(prefix(0xA1B2, 0), HERE) == "on this machine", "there is no process 0"


@pytest.mark.parametrize(
    ("hosts", "machine"), [({}, "another machine or container"), ({"c3d4": "bridge"}, "machine bridge")]
)
def test_a_process_of_another_machine_is_told_with_the_number_of_that_and_its_name_where_that_is_known(hosts, machine):
    there = prefix(0xC3D4, 4711)
    assert host_of(there) == "c3d4"
    assert place_of(there, HERE, hosts) == f"process 4711 on {machine}, DDS host c3d4"


def test_of_another_dds_nothing_is_read_into_its_numbers():
    other = bytes([1, 16, *range(10)]).hex()
    assert host_of(other) == ""
    assert place_of(other, HERE) == f"process {other}"
