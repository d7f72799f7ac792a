"""What a bag says of the type of a topic, and by that its serialised messages to objects, and to columns in batches.

A definition is `ros2msg` text. Other recorders write it in IDL, which rosbags translates, or not at all. There that of
the installed package is taken, where the bag shows by the hash of the type that it is the same.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Collection
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from heave_node.cdr.definitions import DefinitionError, schema_text, type_hash
from mcap.records import Channel, Schema
from numpy.typing import NDArray
from rosbags.typesys import Stores, get_types_from_idl, get_typestore

from heave_bags.cdr.canonical import Canonical
from heave_bags.cdr.columns import ColumnDecoder, Columns, join
from heave_bags.errors import BagError
from heave_bags.mcap.files import TopicSummary
from heave_bags.mcap.read.scan import RawMessage

LOG_TIME = "log_time"
TIME = "time"
_INDEX = re.compile(r"\[\d+\]")
_BATCH = 4096
_BATCH_BYTES = 4 << 20

_OTHER_KINDS = {"ros1": "ROS 1", "ros1msg": "ROS 1", "protobuf": "Protobuf", "json": "JSON", "jsonschema": "JSON"}
_SECTION = "=" * 80 + "\n"
"""Begins the definition of each type in a text of several, with a line that names it."""
_LONGEST_IDL = 1 << 20
"""Characters of a definition in IDL that is translated."""


@dataclass
class BagTopic(TopicSummary):
    """One topic of a bag."""

    schema: str = ""  # definition of its type, `ros2msg`; "" if there is none
    problem: str = ""  # why there is none


def definition(channel: Channel, schema: Schema | None) -> tuple[str, str]:
    """Return the `ros2msg` text of the type of a `channel` with a `schema`, and why there is none; one is ""."""
    if schema is not None and schema.encoding == "ros2msg" and schema.data:
        return schema.data.decode("utf-8", "replace"), ""
    if channel.message_encoding not in ("cdr", ""):
        kind = _OTHER_KINDS.get(channel.message_encoding, channel.message_encoding)
        return "", f"was recorded as {kind}: only messages of ROS 2 (CDR) can be decoded"
    if schema is None or not schema.data:
        return _installed(channel, schema.name if schema else "")
    if schema.encoding == "ros2idl":
        return _by_idl(schema)
    kind = _OTHER_KINDS.get(schema.encoding, schema.encoding or "unknown")
    return "", f"was recorded with a definition of another kind ({kind}), not of ROS 2"


def _installed(channel: Channel, name: str) -> tuple[str, str]:
    """Return the definition of the installed package, if the channel has its hash."""
    stated = channel.metadata.get("topic_type_hash", "")
    with suppress(DefinitionError):
        if stated and type_hash(name) == stated:
            return schema_text(name), ""
    return "", "was recorded without its definition"


def _by_idl(schema: Schema) -> tuple[str, str]:
    """Return the translation of a definition in IDL."""
    text = schema.data[:_LONGEST_IDL].decode("utf-8", "replace")
    parts = [part.partition("\n")[2] for part in text.split(_SECTION)[1:]] if text.startswith(_SECTION) else [text]
    store = get_typestore(Stores.EMPTY)
    try:
        for part in parts:
            store.register(get_types_from_idl(part))
        return store.generate_msgdef(schema.name, ros_version=2)[0], ""
    except Exception:  # whatever a parser of others makes of a damaged definition
        return "", "was recorded with a definition in IDL that cannot be read"


class MessageDecoder:
    """Decodes messages of one topic as objects."""

    def __init__(self, topic: BagTopic) -> None:
        from mcap_ros2.decoder import DecoderFactory  # noqa: PLC0415 - only this way of reading needs it

        self._canonical = Canonical(topic.type, topic.schema)
        schema = Schema(id=1, name=topic.type, encoding="ros2msg", data=topic.schema.encode())
        try:
            self._decode = DecoderFactory().decoder_for("cdr", schema)
        except Exception as error:  # whatever a parser of others makes of a damaged definition
            raise BagError(f"{topic.name}: the definition of {topic.type} cannot be read: {error}") from error
        self.misfits = 0
        """Messages that did not fit their definition."""

    def decode(self, data: bytes) -> Any:
        """Return the message of its `data`; None, and counted, if it does not fit the definition."""
        if self._decode is not None and self._canonical.fits(data):
            try:
                return self._decode(data)
            except (ValueError, LookupError, struct.error, ArithmeticError):
                pass
        self.misfits += 1
        return None


class ColumnReader:
    """Collects the messages of one `topic` and decodes their `fields`, None: all, in batches; sequences longer than
    `longest` are left out, None: none.
    """

    def __init__(self, topic: BagTopic, fields: Collection[str] | None, longest: int | None) -> None:
        self._decoder = ColumnDecoder(topic.type, topic.schema, _field_filter(fields), longest)
        self.misfits = 0
        """Messages that did not fit their definition."""
        self._messages: list[bytes] = []
        self._times: list[int] = []
        self._size = 0
        self._batches: list[tuple[int, Columns]] = []

    def add(self, message: RawMessage) -> None:
        """Take the next message."""
        self._messages.append(message.data)
        self._times.append(message.log_time)
        self._size += len(message.data)
        if len(self._messages) >= _BATCH or self._size >= _BATCH_BYTES:
            self._decode()

    def _decode(self) -> None:
        try:
            columns = self._decoder.decode(self._messages)
        except BagError:
            self._leave_out_misfits()
            if not self._messages:
                return
            columns = self._decoder.decode(self._messages)
        log_time = np.asarray(self._times, dtype=np.int64)
        time = _stamps(columns, log_time) * 1e-9 if self._decoder.has_header else log_time * 1e-9
        self._batches.append((log_time.size, {TIME: time, LOG_TIME: log_time, **columns}))
        self._messages, self._times, self._size = [], [], 0

    def _leave_out_misfits(self) -> None:
        fitting = [index for index, data in enumerate(self._messages) if self._decoder.fits(data)]
        self.misfits += len(self._messages) - len(fitting)
        self._messages = [self._messages[index] for index in fitting]
        self._times = [self._times[index] for index in fitting]

    def finish(self) -> Columns:
        """Return the columns of all messages."""
        if self._messages:
            self._decode()
        if not self._batches:
            return {TIME: np.empty(0), LOG_TIME: np.empty(0, dtype=np.int64)}
        return join(self._batches)


def _stamps(columns: Columns, log_time: NDArray[np.int64]) -> NDArray[np.int64]:
    """Take the stamps out of columns [ns]; where there is none, or none above 0, the log time stands for it."""
    seconds = columns.pop("header.stamp.sec", None)
    nanoseconds = columns.pop("header.stamp.nanosec", None)
    for part in (seconds, nanoseconds):
        if part is None or part.ndim != 1 or part.dtype.kind not in "iu":
            return log_time
    assert seconds is not None and nanoseconds is not None
    stamp = seconds.astype(np.int64) * 1_000_000_000 + nanoseconds.astype(np.int64)
    return np.where(stamp > 0, stamp, log_time)


def _field_filter(fields: Collection[str] | None) -> Callable[[str], bool] | None:
    if fields is None:
        return None
    wanted = tuple(fields)

    def is_wanted(path: str) -> bool:
        if path.startswith("header.stamp."):
            return True
        if _INDEX.sub("[]", path) in wanted:
            return True
        return any(path == name or path.startswith((name + ".", name + "[")) for name in wanted)

    return is_wanted
