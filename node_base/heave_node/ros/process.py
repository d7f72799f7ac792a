"""Run one node as a process: the same start, spin loop, signals and exit status for every node of the suite."""

from __future__ import annotations

import atexit
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from types import FrameType
from typing import Any, NoReturn

import rclpy
from rclpy.lifecycle import TransitionCallbackReturn
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future

from heave_node.parameters import ParameterError
from heave_node.ros.node import HeaveNode
from heave_node.ros.release import RCLError
from heave_node.ros.spin import IDLE_PERIOD, Spinner, spin
from heave_node.ros.transport.environment import is_bound_to_loopback, prepare_environment
from heave_node.ros.transport.exchange import Exchange
from heave_node.ros.transport.exposure import exposed_ports, own_sockets
from heave_node.ros.transport.parents_death import close_with, end_with, exit_at_once, launcher_of
from heave_node.ros.transport.real_time import NICENESS, between_looks
from heave_node.ros.transport.watchdog import watched_end, watched_start

EXIT_OK = 0
EXIT_FAILED = 1
EXIT_REFUSED = 2
EXIT_STUCK = -signal.SIGALRM
"""Exit status, as a parent sees it, of a node that had done its work but was held up by the middleware."""

DELIVERY_SLICE = 0.05
"""Wall time for which messages in memory are handed over before services and timers are served again [s]."""

SHUTDOWN_TIMEOUT = 5
"""Wall time that the middleware has to deliver a node's last message and to shut it down [s]."""


def run_node(node_type: type[HeaveNode], args: list[str] | None = None) -> int:
    """Run a node until the run ends or SIGINT or SIGTERM comes.

    Parameters
    ----------
    node_type : class of the node
    args : command line of ROS; None takes that of the process

    Returns
    -------
    status : for the process to exit with: 0 done, 1 failed, 2 parameters refused. What went wrong is one line on
        standard error, `<node>: <what>`
    """
    return _run([node_type], args, _spin_one)


def run_process(node_type: type[HeaveNode], args: list[str] | None = None) -> NoReturn:
    """Run a node of `node_type` with the command line `args` as `run_node` does, and end this process with its status.

    The middleware's libraries are not taken apart by then: Fast DDS can lock up in that, after all its work is done.
    """
    exit_at_once(run_node(node_type, args))


def run_composed(node_types: Sequence[type[HeaveNode]], args: list[str], *, is_public: bool) -> int:
    """Run all nodes of a run in this process; they hand each other their messages in memory.

    The first node that fails ends the others.

    Parameters
    ----------
    node_types : their classes, that of the clock master first: it is built last, and waits for nobody
    args : command line of ROS
    is_public : other processes get every message of every topic, not only a glance

    Returns the status of `run_node`; the last line on standard error is that of the node that failed first.
    """
    exchange = Exchange(is_public=is_public)
    HeaveNode.exchange = exchange
    return _run(node_types, args, lambda nodes: _spin_composed(nodes, exchange))


def _run(
    node_types: Sequence[type[HeaveNode]], args: list[str] | None, spin_nodes: Callable[[Sequence[HeaveNode]], None]
) -> int:
    launcher = launcher_of(os.environ)
    if launcher is not None:
        end_with(launcher)  # the middleware may never come back from its start
    inherited = own_sockets()
    try:
        notice = prepare_environment()
        with watched_start():
            # A signal ends the nodes, not the context: their last messages must still reach the others.
            rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
            nodes = [node_type() for node_type in node_types]
    except ParameterError as error:
        return _exit_with_message(str(error), EXIT_REFUSED)
    except MemoryError as error:
        return _exit_with_message(f"{node_types[0].name}: {error}", EXIT_FAILED)
    except RCLError as error:  # a keystore without this node's keys, a middleware that is not there
        names = " and ".join(node_type.name for node_type in node_types[:1])
        return _exit_with_message(f"{names}: ROS failed to start: {' '.join(str(error).split())}", EXIT_FAILED)
    exposure = _exposure(nodes[0], inherited)
    if exposure:
        shut_down(nodes)
        return _exit_with_message(f"{nodes[0].name}: {exposure}", EXIT_FAILED)
    if notice:
        nodes[0].get_logger().warning(notice)
    with suppress(KeyboardInterrupt), _ended_by_signals(nodes):
        if launcher is not None:
            close_with(launcher)
        for node in reversed(nodes):
            node.fail_on_error(partial(_start, node))
    spin_nodes(nodes)
    failed = sorted((node for node in nodes if node.failure), key=lambda node: node.failed_at, reverse=True)
    for node in failed:
        _exit_with_message(f"{node.name}: {node.failure}", EXIT_FAILED)
    shut_down(nodes)
    return EXIT_FAILED if failed else EXIT_OK


def _start(node: HeaveNode) -> None:
    if node.run.autostart and node.trigger_configure() == TransitionCallbackReturn.SUCCESS:
        node.trigger_activate()


def _spin_one(nodes: Sequence[HeaveNode]) -> None:
    (node,) = nodes
    if node.hears_past:  # who may be behind gives way to those that a tick waits for
        os.nice(NICENESS)
    node.fail_on_error(lambda: spin(node, node.finished, lambda: _on_idle(node)))
    _leave(node)


def _spin_composed(nodes: Sequence[HeaveNode], exchange: Exchange) -> None:
    """Hand over messages and serve callbacks until every node has finished. One that has failed ends the others."""
    spinner = Spinner(*nodes)
    staying, looked_at = list(nodes), time.monotonic()
    try:
        while staying and rclpy.ok():
            if exchange.wake.done():
                spinner.spin_for(0.0, until=Future())
            else:
                spinner.spin_for(IDLE_PERIOD, until=exchange.wake)
            exchange.deliver(DELIVERY_SLICE)
            if time.monotonic() - looked_at >= IDLE_PERIOD:
                looked_at = time.monotonic()
                for node in staying:
                    _on_idle(node)
            for node in [node for node in staying if node.finished.done()]:
                staying.remove(node)
                _leave(node)
                if node.failure:
                    for other in staying:
                        other.fail(f"{node.name} has failed")
    finally:
        spinner.close()


def _leave(node: HeaveNode) -> None:
    """Let a node that has finished release what it holds; an error in that, such as a full disk, is its failure."""
    if node.has_joined:
        node.fail_on_error(node.on_exit)


def in_namespace(namespace: str) -> list[str]:
    """Return the ROS arguments that put a node into a `namespace`; none for ""."""
    return ["--ros-args", "-r", f"__ns:=/{namespace.strip('/')}"] if namespace else []


def node_beside(name: str, namespace: str, **options: Any) -> Node:
    """Start ROS and return the node of a command beside a run: it takes no part, and the command handles Ctrl-C itself.

    Parameters
    ----------
    name, namespace : of the node; "": in none
    options : of rclpy's Node besides
    """
    with watched_start():
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
        return Node(
            name, namespace=namespace, cli_args=in_namespace(namespace), start_parameter_services=False, **options
        )


def leave_ros(node: Node) -> None:
    """Destroy the `node` of a command whose work is done, and shut ROS down."""
    with watched_end():
        node.destroy_node()
        rclpy.try_shutdown()


def shut_down(nodes: Sequence[HeaveNode]) -> None:
    """Destroy `nodes` whose work is done, and shut ROS down.

    Fast DDS can lock up forever when an endpoint is removed, here or in another process, while one of its timers
    expires. An alarm then ends the process: by that time every file is closed and every message sent.
    """
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.alarm(SHUTDOWN_TIMEOUT)
    for node in nodes:
        if node.has_joined:
            node.fail_on_error(node.wait_until_heard)
    for node in nodes:
        node.destroy_node()
    rclpy.try_shutdown()
    signal.alarm(0)
    atexit.register(signal.alarm, SHUTDOWN_TIMEOUT)  # a program that ends by itself takes the middleware apart


def _exposure(node: HeaveNode, inherited: set[str]) -> str:
    """Say in one line that the transport reaches further than requested; "" where it does not.

    Sockets that this process has `inherited` are another's.
    """
    ports = exposed_ports(node.context.get_domain_id(), inherited) if is_bound_to_loopback() else []
    if not ports:
        return ""
    return (
        f"other hosts can reach {', '.join(ports)}: Fast DDS rejected this suite's profile (see its own errors); "
        "to allow this, use --network or ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET"
    )


def _on_idle(node: HeaveNode) -> None:
    """Let the node check the wall clock, and end it when its launcher is gone."""
    launcher = launcher_of(os.environ)
    if launcher is not None and os.getppid() != launcher:
        node.fail("its parent process has ended")
    node.look_for_hearers()
    node.on_idle()
    between_looks()


@contextmanager
def _ended_by_signals(nodes: Sequence[HeaveNode]) -> Iterator[None]:
    """End `nodes` by SIGINT and SIGTERM from now on; the first of them interrupts what is within by KeyboardInterrupt.

    A node is built within: it loads libraries and compiles, and that is no longer of use.
    """
    is_within = True

    def on_signal(number: int, _: FrameType | None) -> None:
        nonlocal is_within
        for node in nodes:
            node.was_ended = node.was_ended or not node.failure
            node.fail(f"ended by {signal.Signals(number).name}")
        if is_within:
            is_within = False
            raise KeyboardInterrupt

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, on_signal)
    yield
    is_within = False


def _exit_with_message(text: str, status: int) -> int:
    sys.stderr.write(text + "\n")
    return status
