"""What a bag says of the type of a topic, as the `ros2msg` text by which its messages are decoded.

Other recorders write definitions in IDL, or none. There the definition of the installed package is taken, where the bag
shows that it is the same: by the hash of the type, or by the names of all fields.
"""

from __future__ import annotations

import re
from contextlib import suppress

from heave_node.cdr.definitions import DefinitionError, field_names, schema_text, type_hash
from mcap.records import Channel, Schema

_IDL_SECTION = re.compile(r"^IDL: (?P<type>\S+)$", re.MULTILINE)
_IDL_COMMENT = re.compile(r'"(?:\\.|[^"\\])*"|//[^\n]*|/\*.*?\*/', re.DOTALL)
_IDL_ANNOTATION = re.compile(r"@\w+(?:\s*\([^)]*\))?")
_IDL_MEMBER = re.compile(r"(\w+)\s*(?:\[[^\]]*\]\s*)*$")
_OTHER_KINDS = {"ros1": "ROS 1", "ros1msg": "ROS 1", "protobuf": "Protobuf", "json": "JSON", "jsonschema": "JSON"}


def definition(channel: Channel, schema: Schema | None) -> tuple[str, str]:
    """Return the `ros2msg` text of the type of a `channel` by its `schema`, and why there is none; one is ""."""
    if schema is not None and schema.encoding == "ros2msg" and schema.data:
        return schema.data.decode("utf-8", "replace"), ""
    if channel.message_encoding not in ("cdr", ""):
        kind = _OTHER_KINDS.get(channel.message_encoding, channel.message_encoding)
        return "", f"was recorded as {kind}: only messages of ROS 2 (CDR) can be decoded"
    if schema is None or not schema.data:
        return _installed(channel, schema.name if schema else "")
    if schema.encoding == "ros2idl":
        return _by_idl(channel, schema)
    kind = _OTHER_KINDS.get(schema.encoding, schema.encoding or "unknown")
    return "", f"was recorded with a definition of another kind ({kind}), not of ROS 2"


def _installed(channel: Channel, name: str) -> tuple[str, str]:
    """Return the definition of the installed package, if the channel has its hash."""
    stated = channel.metadata.get("topic_type_hash", "")
    with suppress(DefinitionError):
        if stated and type_hash(name) == stated:
            return schema_text(name), ""
    return "", "was recorded without its definition"


def _by_idl(channel: Channel, schema: Schema) -> tuple[str, str]:
    """Return the definition of the installed package, if that in IDL has the same fields."""
    problem = "was recorded with its definition in IDL"
    try:
        text = schema_text(schema.name)
        if not _has_same_fields(schema.data.decode("utf-8", "replace"), schema.name):
            return "", f"{problem}, which differs from that of the installed package"
    except DefinitionError:
        package = schema.name.split("/", 1)[0]
        return "", f"{problem}: it can be decoded where {package} is installed (AMENT_PREFIX_PATH)"
    stated = channel.metadata.get("topic_type_hash", "")
    if stated and type_hash(schema.name) not in ("", stated):
        return "", f"{problem}, and the installed package has another version of it"
    return text, ""


def _has_same_fields(text: str, name: str) -> bool:
    """Return whether each type that an IDL text defines, `name` among them, has the fields of the installed one."""
    marks = list(_IDL_SECTION.finditer(text))
    ends = [mark.start() for mark in marks[1:]] + [len(text)]
    sections = {mark["type"]: text[mark.end() : end] for mark, end in zip(marks, ends, strict=True)}
    return name in (sections or {name: ""}) and all(
        _idl_fields(section, kind) == field_names(schema_text(kind).split("\n=====", 1)[0])
        for kind, section in (sections or {name: text}).items()
    )


def _idl_fields(section: str, kind: str) -> list[str]:
    plain = _IDL_ANNOTATION.sub("", _IDL_COMMENT.sub("", section))
    struct = re.search(rf"\bstruct\s+{re.escape(kind.rsplit('/', 1)[-1])}\s*\{{(.*?)\}}", plain, re.DOTALL)
    members = [member.strip() for member in struct[1].split(";")] if struct else []
    names = [match[1] for member in members if (match := _IDL_MEMBER.search(member))]
    return [] if names == ["structure_needs_at_least_one_member"] else names
