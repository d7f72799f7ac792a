"""What can be switched off in the controller by itself, to see what it saves and what it costs."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from typing import Any
from unittest.mock import patch

from heave_core.modes_table import ModeGuard
from winch_controller_node.adviser import hypothesis
from winch_controller_node.adviser.component import Adviser
from winch_controller_node.core.estimation import sense_design
from winch_controller_node.core.supervision import guard_checks, mode_machine, supervision_design
from winch_controller_node.core.supervision.modes import mode_design
from winch_controller_node.core.supervision.watch.encoder_reflex import Act, EncoderReflex

NEVER = 1e9
"""Price at which no hypothesis is accepted [nats]; ratio and share that nothing reaches."""

Switch = tuple[Any, str, Any]
"""Owner and name of a part of the controller, and what stands in its place while a case is run."""


def _gives(value: Any) -> Callable[..., Any]:
    """Return a function that does nothing but give a `value`."""
    return lambda *_, **__: value


def _unpriced(*names: str) -> Switch:
    """Return the switch with which no quantity of these `names` of the judge is found."""
    return hypothesis, "PRICES", {**hypothesis.PRICES, **{getattr(hypothesis, name): NEVER for name in names}}


def _with(owner: Any, name: str, value: float) -> Switch:
    """Return the switch with which the constant of a `name` that the core gets from a module, `owner`, is a `value`."""
    return owner, "CONSTANTS", {**owner.CONSTANTS, name: value}


def _without_limit(name: str) -> Switch:
    """Return the switch with which no amplitude is too large by the guard's limit of a `name`."""
    return guard_checks, name, getattr(guard_checks, name)._replace(ratio=NEVER)


def _without_gates(*given: Any) -> dict[str, Any]:
    """Return the values of the core's ModeDesign in which no gate keeps compensation from beginning."""
    values = mode_design(*given)
    return values | {"rows": [row | {"guards": row["guards"] & ~ModeGuard.IF_GATES_OPEN} for row in values["rows"]]}


LEARNING: Mapping[str, Sequence[Switch]] = {
    "winch": [(Adviser, "_take_winch", _gives(None))],
    "encoder scale": [(Adviser, "_take_encoder", _gives(None)), _unpriced("ENCODER_SCALE")],
    "mru": [_unpriced("MRU_SCALE", "MRU_OFFSET", "MRU_DELAY", "DRIFT", "HIGH_PASS")],
    "depth scale": [_unpriced("DEPTH_SCALE")],
    "cable": [_unpriced("INERTIA", "DAMPING")],
    "exclusion": [(hypothesis, "EXCLUSION", NEVER)],
    "sea": [(Adviser, "_look_at_sea", _gives(None))],
    "all learning": [(Adviser, name, _gives(False)) for name in ("_look_at_winch", "_judge", "_look_at_sea")],
}
"""Findings of the adviser."""

NO_NOISE = sense_design.GATES | {"fewest_noise": NEVER, "noise_unknown": 1.0}
REFLEXES: Mapping[str, Sequence[Switch]] = {
    "encoder reflex": [(EncoderReflex, "look", _gives(Act.NOTHING))],
    "exclusion after jumps": [(sense_design, "EXCLUDES_JUMPED", False)],
    "sensor noise": [(sense_design, "GATES", NO_NOISE)],
    "share by the sea": [_with(supervision_design, "cautious", 1.0)],
    "authority": [_with(guard_checks, "worth", NEVER)],
}
"""Reflexes of the core within a tick."""

GUARD: Mapping[str, Sequence[Switch]] = {
    "drum check": [_without_limit("DRUM")],
    "swing check": [_without_limit("SWING")],
    "depth check": [_without_limit("DEPTH")],
    "mismatch check": [_without_limit("MISMATCH")],
    "waves check": [_with(guard_checks, "full_share", NEVER)],
}
CHECKS: Mapping[str, Sequence[Switch]] = {
    "gates": [(mode_machine, "mode_design", _without_gates)],
    **GUARD,
    "guard": [switch for switches in GUARD.values() for switch in switches],
}
"""Checks of supervision."""

ALL: Mapping[str, Sequence[Switch]] = {**LEARNING, **REFLEXES, **CHECKS}
"""Everything that can be switched off, by name."""


@contextmanager
def switched_off(name: str) -> Iterator[None]:
    """Have this process run without a part of the controller, by its `name` in `ALL`, within; empty: with all."""
    with ExitStack() as stack:
        for switch in ALL[name] if name else ():
            stack.enter_context(patch.object(*switch))
        yield
