"""What a bag says of the type of a topic, as the `ros2msg` text by which its messages are decoded.

Other recorders write definitions in IDL, which rosbags translates, or none. There the definition of the installed
package is taken, where the bag shows by the hash of the type that it is the same.
"""

from __future__ import annotations

from contextlib import suppress

from heave_node.cdr.definitions import DefinitionError, schema_text, type_hash
from mcap.records import Channel, Schema
from rosbags.typesys import Stores, get_types_from_idl, get_typestore

_OTHER_KINDS = {"ros1": "ROS 1", "ros1msg": "ROS 1", "protobuf": "Protobuf", "json": "JSON", "jsonschema": "JSON"}
_SECTION = "=" * 80 + "\n"
"""Begins the definition of each type in a text of several, with a line that names it."""
_LONGEST_IDL = 1 << 20
"""Characters of a definition in IDL that is translated."""


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
