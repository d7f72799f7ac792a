"""Which event restarts which memory: one table, from which every event of the controller is done."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import Enum

from winch_controller_node.core.parts import ControllerParts


class Event(Enum):
    """What can make a memory void."""

    ASKED = "an operator asks for a mode"
    TRIED = "an operator asks for a mode that moves the winch"
    FOLLOWS = "the winch begins to follow the sea, or another unit depth is the mean"
    TENSION_HELD = "constant tension begins or ends"
    REDESIGNED = "an operator has stated other nominal parameters"
    CORRECTED = "something else is assumed of winch, cable or a sensor"
    ENCODER_CORRECTED = "another scale of the encoder is assumed"
    TIP_MOVED = "the boom tip is assumed to be elsewhere"
    COUNT_JUMPED = "the count has jumped, and orders in the old one still act"


MEMORIES: Mapping[str, Callable[[ControllerParts], object]] = {
    "command timeouts": lambda core: core._supervisor.cancel_timeout(),
    "attempts after harm": lambda core: core._supervisor.guard.release(),
    "latched envelope": lambda core: core.envelope.acknowledge(),
    "frozen encoder": lambda core: core.observer.encoder.trust(),
    "steps of sensors": lambda core: core.observer.trust(),
    "excluded encoder": lambda core: core.observer.use_encoder(),
    "direction of the encoder": lambda core: core._encoder.restart(),
    "plan of the law": lambda core: core._in_force.law.reset(),
    "mean tension": lambda core: core._estimation.restart_tension(),
    "past readings": lambda core: core._estimation.reset_readings(),
    "sea of the estimator": lambda core: core._estimation.reset_sea(),
    "sea of guard and gates": lambda core: core._supervisor.reset_sea(),
    "steps of the order": lambda core: core._command.ease(),
    "orders and encoder": lambda core: core._winch.drum.restart(),
}
"""How each memory is restarted."""

RESTARTS: Mapping[Event, tuple[str, ...]] = {
    Event.ASKED: (
        "command timeouts",
        "attempts after harm",
        "latched envelope",
        "steps of sensors",
    ),
    Event.TRIED: ("frozen encoder", "excluded encoder", "direction of the encoder"),
    Event.FOLLOWS: ("plan of the law",),
    Event.TENSION_HELD: ("mean tension",),
    Event.REDESIGNED: ("past readings", "sea of the estimator"),
    Event.CORRECTED: ("steps of the order",),
    Event.ENCODER_CORRECTED: ("direction of the encoder", "orders and encoder"),
    Event.TIP_MOVED: ("sea of guard and gates",),
    Event.COUNT_JUMPED: ("past readings",),
}
"""Memories that an event restarts, in this order; what the encoder reflex of the core restarts is there."""


def restart(core: ControllerParts, event: Event) -> None:
    """Restart all memories of a controller, `core`, that an `event` makes void."""
    for memory in RESTARTS[event]:
        MEMORIES[memory](core)
