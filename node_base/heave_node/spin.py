"""The one spin loop of the suite.

The events executor is three times as fast as the default one. Its `spin` does not dispatch in every release, so the
loop asks it to spin until a
future completes, in slices; between slices a node may look at the wall clock.
"""

from __future__ import annotations

from collections.abc import Callable

import rclpy
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from rclpy.task import Future

IDLE_PERIOD = 0.2
"""Wall time between two calls of `on_idle` [s]."""


def spin(node: Node, finished: Future, on_idle: Callable[[], None] | None = None) -> None:
    """Serve the callbacks of `node` until `finished` completes or the context is shut down (SIGINT)."""
    executor = EventsExecutor()
    executor.add_node(node)
    try:
        while rclpy.ok() and not finished.done():
            executor.spin_until_future_complete(finished, IDLE_PERIOD)
            if on_idle is not None and rclpy.ok() and not finished.done():
                on_idle()
    finally:
        executor.remove_node(node)
        executor.shutdown()
