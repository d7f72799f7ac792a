"""Observations and beliefs as serialised messages, and back: exact to the bit, and nothing that came is trusted."""

from __future__ import annotations

import math
from collections.abc import Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
from heave_node.cdr.packer import Packer
from heave_node.interface import topics
from heave_node.numerics.arrays import Array

from winch_controller_node.beliefs.beliefs import Adopted, Belief, Beliefs, EncoderScale, Finding
from winch_controller_node.beliefs.quantities import QUANTITIES, RESTATED
from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.design.wire import DesignParts, WireError, design_of, parts_of
from winch_controller_node.interface.observations import READING_COLUMNS, TICK_COLUMNS, Observations

_OBSERVATIONS = Packer(
    topics.CONTROLLER_OBSERVATIONS.type,
    (
        *("header.stamp", "first", "tick_columns", "ticks", "rows", "reading_columns", "readings", "epoch", "beliefs"),
        *("excluded", "is_trusted", "nominal", "restated", "restated_values"),
    ),
)
_BELIEFS = Packer(
    topics.CONTROLLER_BELIEFS.type,
    (
        *("header.stamp", "asked", "number", "values", "encoder", "excluded", "authority", "findings", "design"),
        "adopted",
    ),
)


def observations_message(observations: Observations, nominal: str, stamp: int) -> bytes:
    """Return a batch of `observations` as a message of `stamp`, the start of its last tick [ns].

    `nominal` : active parameters without any belief, as `parameters_text` gives them
    """
    o = observations
    return _OBSERVATIONS.pack(
        *(stamp, o.first, TICK_COLUMNS, _row(o.ticks), o.rows, READING_COLUMNS, _row(o.readings), o.epoch, o.beliefs),
        *(o.excluded, o.is_trusted, nominal, [path for path, _ in o.restated], [value for _, value in o.restated]),
    )


def observations_of(message: Any) -> Observations:
    """Return what a heave_msgs/Observations, the `message`, holds but the nominal.

    Raises WireError where a table does not fit its columns, or the columns are not those of this release.
    """
    for name, columns in (("tick_columns", TICK_COLUMNS), ("reading_columns", READING_COLUMNS)):
        if tuple(getattr(message, name)) != columns:
            raise WireError(f"observations: {name} must be {', '.join(columns)}")
    if len(message.restated) != len(message.restated_values) or set(message.restated) - set(RESTATED):
        raise WireError(f"observations: restated must be of {', '.join(RESTATED)}, each with its value")
    return Observations(
        first=message.first,
        ticks=_table("ticks", message.ticks, len(TICK_COLUMNS)),
        rows=tuple(message.rows),
        readings=_table("readings", message.readings, len(READING_COLUMNS)),
        epoch=message.epoch,
        beliefs=message.beliefs,
        excluded=message.excluded,
        is_trusted=message.is_trusted,
        restated=tuple(zip(message.restated, message.restated_values, strict=True)),
    )


def beliefs_message(beliefs: Beliefs, stamp: int) -> bytes:
    """Return the answer `beliefs` as a message; `stamp` is when they come into force [ns]."""
    adopted = beliefs.adopted
    return _BELIEFS.pack(
        stamp,
        beliefs.asked,
        beliefs.number,
        list(beliefs.values.values()),
        [] if beliefs.encoder is None else [beliefs.encoder],
        beliefs.excluded,
        beliefs.authority,
        beliefs.findings,
        [] if beliefs.design is None else [_design_fields(beliefs.design)],
        [] if adopted is None else [(adopted.tick, _row(adopted.estimate), _row(adopted.covariance))],
    )


def beliefs_of(message: Any) -> Beliefs:
    """Return the beliefs that a heave_msgs/Beliefs, the `message`, holds.

    Raises WireError, naming the part, for an unknown quantity, a number that is not finite or out of range, a design
    that cannot be made, and a state that does not fit.
    """
    values = [Belief(b.quantity, b.value, b.sigma, b.nats, b.since) for b in message.values]
    for belief in values:
        if belief.quantity not in QUANTITIES:
            raise WireError(f"beliefs: no quantity {belief.quantity!r}")
        if not math.isfinite(belief.value):
            raise WireError(f"beliefs: {belief.quantity} is {belief.value}")
    if len({belief.quantity for belief in values}) != len(values):
        raise WireError("beliefs: a quantity appears twice")
    if not 0.0 <= message.authority <= 1.0:
        raise WireError(f"beliefs: authority must be from 0 to 1; got {message.authority}")
    if message.asked < 0 or max(map(len, (message.encoder, message.design, message.adopted))) > 1:
        raise WireError("beliefs: asked is negative, or there are several scales, designs or adopted states")
    design = _design(message.design[0]) if message.design else None
    return Beliefs(
        asked=message.asked,
        number=message.number,
        values=MappingProxyType({belief.quantity: belief for belief in values}),
        encoder=_encoder(message.encoder[0]) if message.encoder else None,
        excluded=message.excluded,
        authority=message.authority,
        findings=tuple(
            Finding(f.code, f.quantity, f.value, f.unit, f.nominal, f.nats, f.since) for f in message.findings
        ),
        design=design,
        adopted=_adopted(message.adopted[0], design) if message.adopted else None,
    )


def _design_fields(design: ControllerDesign) -> tuple[object, object]:
    """Return the fields of heave_msgs/DesignArrays in their order."""
    parts = parts_of(design)
    return [(name, array.shape, _row(array)) for name, array in parts.arrays.items()], list(parts.texts.items())


def _design(message: Any) -> ControllerDesign:
    arrays = {one.name: _shaped(one.name, one.values, one.shape) for one in message.arrays}
    texts = {one.name: tuple(one.texts) for one in message.texts}
    if len(arrays) != len(message.arrays) or len(texts) != len(message.texts):
        raise WireError("design: a name appears twice")
    return design_of(DesignParts(arrays, texts))


def _encoder(message: Any) -> EncoderScale:
    scale = EncoderScale(message.since, message.scale, message.reading, message.payout)
    if not all(map(math.isfinite, scale)) or scale.scale == 0.0:
        raise WireError(f"beliefs: encoder scale {scale.scale} about a reading of {scale.reading} at {scale.payout} m")
    return scale


def _adopted(message: Any, design: ControllerDesign | None) -> Adopted:
    order = len(message.estimate)
    if design is not None and order != design.model.order:
        raise WireError(f"beliefs: adopted state of {order} numbers for a design of {design.model.order} states")
    estimate = _shaped("adopted estimate", message.estimate, (order,))
    covariance = _shaped("adopted covariance", message.covariance, (order, order))
    if not (np.all(np.isfinite(estimate)) and np.all(np.isfinite(covariance))):
        raise WireError("beliefs: the adopted state holds a value that is not finite")
    return Adopted(message.tick, estimate, covariance)


def _row(array: Array) -> Array:
    """Return the numbers of an array row by row, in the type of the message."""
    return np.asarray(array, dtype="<f8").reshape(-1)


def _table(name: str, values: Sequence[float], columns: int) -> Array:
    if len(values) % columns:
        raise WireError(f"observations: {name} has {len(values)} numbers, no multiple of {columns}")
    return _shaped(name, values, (len(values) // columns, columns))


def _shaped(name: str, values: Sequence[float], shape: Sequence[int]) -> Array:
    array = np.array(values, dtype=float)
    if array.size != math.prod(shape):
        raise WireError(f"{name} has {array.size} numbers for the shape {tuple(shape)}")
    return array.reshape(tuple(shape))
