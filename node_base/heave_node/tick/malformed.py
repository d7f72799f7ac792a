"""What is wrong with a message of the tick protocol, in words, "" where nothing is; and how it is refused.

Messages come from whoever publishes on the topic: their lists need not fit together, their numbers need not be numbers.
"""

from __future__ import annotations

import math
from collections.abc import Sized

from heave_msgs.msg import TickJoin, TickRoster, TickStatus

from heave_node.tick.protocol import Part
from heave_node.tick.speakers import ANYONE


class ProtocolError(Exception):
    """A message of the tick protocol that is rejected; says why, "" where its sender is not part of the run."""


def expect_no(fault: str) -> None:
    """Refuse a message of the protocol that has a `fault`; "" says that it has none."""
    if fault:
        raise ProtocolError(fault)


def expect_sender(identity: str, lawful: str) -> None:
    """Refuse a message of the protocol that comes from another process (`identity`) than the `lawful` one."""
    if ANYONE not in (identity, lawful) and identity != lawful:
        raise ProtocolError


def fault_in_join(message: TickJoin) -> str:
    """Check that the node of a `message` has a name, and each topic its count."""
    if not message.node:
        return "it names no node"
    return _unequal(outputs=message.outputs, matched_subscriptions=message.matched_subscriptions) or _unequal(
        inputs=message.inputs, matched_publishers=message.matched_publishers
    )


def fault_in_roster(message: TickRoster) -> str:
    """Check that each counter of a `message` has its node, process and topic, and that the tick has a length."""
    if message.epoch < 1:
        return "its epoch is 0"
    if not (math.isfinite(message.tick_period) and message.tick_period > 0.0):
        return f"its tick_period is {message.tick_period} s"
    return _unequal(nodes=message.nodes, identities=message.identities, topics=message.topics)


def fault_in_lead(part: Part, counts: int, outputs: int) -> str:
    """Check the number of the tick of a master's `part`, and that it has a count for each entry of the roster.

    `counts` is the number of entries, `outputs` that of those of the master.
    """
    if part.epoch < 1 or part.tick < 1:
        return f"its epoch is {part.epoch} and its tick {part.tick}; both count from 1"
    return _wrong_number(part.published, counts) or _unknown_output(part, outputs)


def fault_in_part(part: Part, outputs: int) -> str:
    """Check that a `part` has a count for each of the `outputs` that the roster has for the node, and no others."""
    return _wrong_number(part.published, outputs) or _unknown_output(part, outputs)


def fault_in_status(message: TickStatus) -> str:
    """Check that the state of a `message` is a known one, and that each topic has its count."""
    if message.state > TickStatus.FAILED:
        return f"its state is {message.state}"
    return _unequal(topics=message.topics, published=message.published)


def _unequal(**lists: Sized) -> str:
    lengths = {name: len(entries) for name, entries in lists.items()}
    if len(set(lengths.values())) == 1:
        return ""
    return "it has " + ", ".join(f"{length} {name}" for name, length in lengths.items())


def _wrong_number(published: Sized, expected: int) -> str:
    return "" if len(published) == expected else f"it has {len(published)} counts instead of {expected}"


def _unknown_output(part: Part, outputs: int) -> str:
    for output, _ in part.messages:
        if output >= outputs:
            return f"it has a message of output {output} of {outputs}"
    return ""
