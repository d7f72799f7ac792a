"""The one spin loop of the suite, and what its executor needs of callbacks.

The events executor is three times as fast as the default one, which stands in where a release of ROS has none. Its
`spin` does not dispatch in every release, so the loop asks it to spin until a future completes, in slices; between
slices a node may check the wall clock.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

import rclpy
from rclpy.node import Node
from rclpy.task import Future

from heave_node.ros.release import EventsExecutor
from heave_node.ros.transport.identity import identity_of_sender

IDLE_PERIOD = 0.2
"""Wall time between two calls of `on_idle` [s]."""

_WITH_INFORMATION = inspect.Signature(
    [inspect.Parameter(name, inspect.Parameter.POSITIONAL_ONLY) for name in ("message", "information")]
)
"""A callback with two arguments makes rclpy pass the sender."""


def sender_callback(handle: Callable[[Any, str], object]) -> Callable[..., None]:
    """Return `handle`, which takes a message and the identity of the process that sent it, as a callback."""
    return timed_callback(lambda message, identity, _: handle(message, identity))


def timed_callback(handle: Callable[[Any, str, int], object]) -> Callable[..., None]:
    """Return `handle`, which takes a message, who sent it, and when, as a callback.

    The identity is that of the sender's process; the time is by the sender's clock [ns], 0 where the middleware does
    not tell. The events executor of some releases gives message and information as one argument, others as two.
    """
    return with_information(
        lambda message, info: handle(message, identity_of_sender(info), int(info.get("source_timestamp", 0)))
    )


def with_information(handle: Callable[[Any, Any], object]) -> Callable[..., None]:
    """Return `handle`, which takes a message and the middleware's information on it, as a callback."""

    def on_message(*given: Any) -> None:
        message, info = given if len(given) == 2 else given[0]
        handle(message, info)

    on_message.__signature__ = _WITH_INFORMATION  # type: ignore[attr-defined]
    return on_message


class Spinner:
    """Serves the callbacks of `nodes`."""

    def __init__(self, *nodes: Node) -> None:
        self._nodes = nodes
        self._executor = EventsExecutor()
        for node in nodes:
            self._executor.add_node(node)

    def spin_for(self, seconds: float, until: Future[Any] | None = None) -> None:
        """Serve callbacks for `seconds` of wall time, or `until` a future completes."""
        self._executor.spin_until_future_complete(Future() if until is None else until, seconds)

    def close(self) -> None:
        """Stop serving callbacks."""
        for node in self._nodes:
            self._executor.remove_node(node)
        self._executor.shutdown()


def spin(node: Node, finished: Future[Any], on_idle: Callable[[], None]) -> None:
    """Serve the callbacks of `node` until `finished` completes or the context is shut down.

    Parameters
    ----------
    node : whose callbacks are served
    finished : ends the loop when it completes
    on_idle : called every IDLE_PERIOD, to check the wall clock
    """
    spinner = Spinner(node)
    try:
        while rclpy.ok() and not finished.done():
            spinner.spin_for(IDLE_PERIOD, until=finished)
            if not finished.done():
                on_idle()
    finally:
        spinner.close()
