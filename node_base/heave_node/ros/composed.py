"""The spin loop of a process that holds all nodes of a run: messages in memory, and in between what comes by ROS."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import rclpy
from rclpy.task import Future

from heave_node.ros.node import HeaveNode
from heave_node.ros.spin import IDLE_PERIOD, Spinner
from heave_node.ros.transport.exchange import Exchange

DELIVERY_SLICE = 0.02
"""Wall time for which messages in memory are handed over before services and timers are served again [s]."""


def spin_composed(
    nodes: Sequence[HeaveNode],
    exchange: Exchange,
    on_idle: Callable[[HeaveNode], None],
    leave: Callable[[HeaveNode], None],
) -> None:
    """Hand over messages and serve callbacks until every node has finished. One that has failed ends the others.

    Parameters
    ----------
    nodes : that share this process
    exchange : of their topics
    on_idle : called for each node every IDLE_PERIOD of wall time
    leave : called for each node once it has finished, while the others still listen
    """
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
                    on_idle(node)
            for node in [node for node in staying if node.finished.done()]:
                staying.remove(node)
                leave(node)
                if node.failure:
                    for other in staying:
                        other.fail(f"{node.name} has failed")
    finally:
        spinner.close()
