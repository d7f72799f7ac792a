"""Which ports of this process other hosts reach, as the kernel shows them."""

import socket
import sys

import pytest
from heave_node.ros.transport.exposure import exposed_ports, own_sockets

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="the kernel's tables of sockets are Linux's")

DOMAIN = 232  # the last one; none of its ports is used by a test that speaks DDS
PORT = 7400 + 250 * DOMAIN + 99


@pytest.fixture
def bound():
    """Bind UDP sockets for the time of a test."""
    sockets = []

    def bind(address: str, port: int, family: socket.AddressFamily = socket.AF_INET) -> None:
        sockets.append(socket.socket(family, socket.SOCK_DGRAM))
        sockets[-1].bind((address, port))

    yield bind
    for one in sockets:
        one.close()


def test_a_port_on_loopback_is_not_exposed(bound):
    bound("127.0.0.1", PORT)
    assert exposed_ports(DOMAIN) == []


def test_a_port_on_every_interface_is(bound):
    bound("127.0.0.1", PORT)
    bound("0.0.0.0", PORT + 1)
    assert exposed_ports(DOMAIN) == [f"0.0.0.0:{PORT + 1}"]


def test_a_port_that_a_launch_has_left_open_is_not_this_process_own(bound):
    bound("0.0.0.0", PORT)
    inherited = own_sockets()
    bound("0.0.0.0", PORT + 1)
    assert exposed_ports(DOMAIN, inherited) == [f"0.0.0.0:{PORT + 1}"]


def test_a_multicast_group_is(bound):
    bound("239.255.0.1", PORT)
    assert exposed_ports(DOMAIN) == [f"239.255.0.1:{PORT}"]


@pytest.mark.skipif(not socket.has_ipv6, reason="needs IPv6")
@pytest.mark.parametrize(("address", "found"), [("::", [f":::{PORT}"]), ("::1", [])])
def test_addresses_of_ip_6_are_told_apart_too(bound, address, found):
    bound(address, PORT, socket.AF_INET6)
    assert exposed_ports(DOMAIN) == found


def test_ports_of_other_domains_and_of_a_nodes_own_are_not_its_concern(bound):
    bound("0.0.0.0", 0)
    bound("0.0.0.0", PORT)
    assert exposed_ports(DOMAIN - 1) == []
