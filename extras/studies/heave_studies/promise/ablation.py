"""What can be switched off in the controller by itself, to see what it saves and what it costs.

Each row names attributes of the code and what stands in their place while a case is run. Of the compiled core these are
constants that fill its design.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from typing import Any, NamedTuple

PACKAGE = "winch_controller_node"
NEVER = 1e9
"""Price at which no hypothesis is accepted [nats]; ratio and share that nothing reaches."""


class Switch(NamedTuple):
    """A part of the controller in another form: its `place`, as "module:owner.name", and its `value` then."""

    place: str
    value: Any


Switches = Callable[[], list[Switch]]


def _gives(value: Any) -> Callable[..., Any]:
    """Return a function that does nothing but give a `value`."""
    return lambda *_, **__: value


def _unpriced(*names: str) -> list[Switch]:
    """Return the switches with which no quantity of these `names` of the judge is found."""
    held = import_module(f"{PACKAGE}.adviser.hypothesis")
    return [Switch("adviser.hypothesis:PRICES", {**held.PRICES, **{getattr(held, name): NEVER for name in names}})]


def _without_limit(name: str) -> list[Switch]:
    """Return the switch with which no amplitude is too large by the guard's limit of a `name`."""
    held = import_module(f"{PACKAGE}.core.supervision.guard_checks")
    return [Switch(f"core.supervision.guard_checks:{name}", getattr(held, name)._replace(ratio=NEVER))]


def _noise_as_stated() -> list[Switch]:
    """Return the switch with which no noise is found in the readings."""
    held = import_module(f"{PACKAGE}.core.estimation.sense_design").GATES
    return [Switch("core.estimation.sense_design:GATES", held | {"fewest_noise": NEVER, "noise_unknown": 1.0})]


LEARNING: Mapping[str, Switches] = {
    "winch": lambda: [Switch("adviser.component:Adviser._take_winch", _gives(None))],
    "encoder scale": lambda: [
        Switch("adviser.component:Adviser._take_encoder", _gives(None)),
        *_unpriced("ENCODER_SCALE"),
    ],
    "mru": lambda: _unpriced("MRU_SCALE", "MRU_OFFSET", "MRU_DELAY", "DRIFT", "HIGH_PASS"),
    "depth scale": lambda: _unpriced("DEPTH_SCALE"),
    "cable": lambda: _unpriced("INERTIA", "DAMPING"),
    "exclusion": lambda: [Switch("adviser.hypothesis:EXCLUSION", NEVER)],
    "sea": lambda: [Switch("adviser.component:Adviser._look_at_sea", _gives(None))],
    "all learning": lambda: [
        Switch(f"adviser.component:Adviser.{name}", _gives(False))
        for name in ("_look_at_winch", "_judge", "_look_at_sea")
    ],
}
"""Findings of the adviser."""

REFLEXES: Mapping[str, Switches] = {
    "encoder reflex": lambda: [
        Switch(
            "core.supervision.watch.encoder_reflex:EncoderReflex.look",
            _gives(import_module(f"{PACKAGE}.core.supervision.watch.encoder_reflex").Act.NOTHING),
        )
    ],
    "exclusion after jumps": lambda: [Switch("core.estimation.sense_design:EXCLUDES_JUMPED", False)],
    "sensor noise": _noise_as_stated,
    "caution in another sea": lambda: [Switch("core.supervision.supervision_design:CAUTIOUS", 1.0)],
    "authority": lambda: [Switch("core.supervision.guard_checks:WORTH", NEVER)],
}
"""Reflexes of the core within a tick."""

CHECKS: Mapping[str, Switches] = {
    "wait for the sea": lambda: [Switch("core.supervision.supervision_design:LONGEST_WAIT", 0.0)],
    "drum check": lambda: _without_limit("DRUM"),
    "swing check": lambda: _without_limit("SWING"),
    "depth check": lambda: _without_limit("DEPTH"),
    "mismatch check": lambda: _without_limit("MISMATCH"),
    "waves check": lambda: [Switch("core.supervision.guard_checks:FULL_SHARE", NEVER)],
    "guard": lambda: [
        switch
        for name in ("drum check", "swing check", "depth check", "mismatch check", "waves check")
        for switch in CHECKS[name]()
    ],
}
"""Checks of supervision."""

ALL: Mapping[str, Switches] = {**LEARNING, **REFLEXES, **CHECKS}
"""Everything that can be switched off, by name."""


def part(place: str) -> tuple[Any, str]:
    """Return the owner of the part at a `place`, and its name there.

    Raises AttributeError where there is none.
    """
    module, path = place.split(":")
    *owners, name = path.split(".")
    target: Any = import_module(f"{PACKAGE}.{module}")
    for owner in owners:
        target = getattr(target, owner)
    if not hasattr(target, name):
        raise AttributeError(f"{place}: there is no such part")
    return target, name


@contextmanager
def switched_off(name: str) -> Iterator[None]:
    """Have this process run without a part of the controller, by its `name` in `ALL`, within; empty: with all."""
    switches = [(*part(place), value) for place, value in (ALL[name]() if name else ())]
    kept = [
        vars(owner)[attribute] if isinstance(owner, type) else getattr(owner, attribute)
        for owner, attribute, _ in switches
    ]
    for owner, attribute, value in switches:
        setattr(owner, attribute, value)
    try:
        yield
    finally:
        for (owner, attribute, _), value in zip(switches, kept, strict=True):
            setattr(owner, attribute, value)
