"""Tracing points of a node's ticks, as ros2_tracing and its tools know them: a callback that begins and ends."""

from __future__ import annotations

import ctypes
from contextlib import suppress

LIBRARY = "libtracetools.so"
"""Of ros2_tracing, which rcl is linked with; without it, or built without LTTng, nothing is traced."""


class TickTrace:
    """The ticks of a node as the callback NODE/tick of the events callback_start and callback_end."""

    def __init__(self, node: str) -> None:
        self._callback = ctypes.c_void_p(id(self))
        self._library: ctypes.CDLL | None = None
        with suppress(OSError, AttributeError):  # there is none, or one that was built without its functions
            library = ctypes.CDLL(LIBRARY)
            library.ros_trace_rclcpp_callback_register(self._callback, f"{node}/tick".encode())
            self._library = library

    def began(self) -> None:
        """Mark the start of this node's part of a tick."""
        if self._library is not None:
            self._library.ros_trace_callback_start(self._callback, ctypes.c_bool(False))

    def ended(self) -> None:
        """Mark its end."""
        if self._library is not None:
            self._library.ros_trace_callback_end(self._callback)
