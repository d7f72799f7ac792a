"""Message definitions of installed interface packages, as a bag needs them: `ros2msg` schema texts and type hashes.

Read from the ament index (`share/PACKAGE/msg`), without importing any message.
"""

from __future__ import annotations

import json
import os
import re
import sys
from functools import cache
from pathlib import Path

from heave_node.cdr.layout import PRIMITIVES, SEPARATOR, field_lines

_NAME = re.compile(r"[a-z][a-z0-9_]*/msg/[A-Z][A-Za-z0-9]*")


class DefinitionError(LookupError):
    """No installed package defines a message type."""


def prefixes() -> list[Path]:
    """Return the installation prefixes that may hold interface packages, in order of precedence."""
    named = [Path(part) for part in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if part]
    return [*named, Path(sys.prefix)]


def _split(message_type: str) -> tuple[str, str]:
    parts = message_type.split("/")
    if len(parts) not in (2, 3) or not all(parts):
        raise DefinitionError(f"{message_type!r} is not the name of a message type (package/msg/Type)")
    return parts[0], parts[-1]


def is_installed(message_type: str) -> bool:
    """Return whether an installed interface package defines `message_type`, `package/msg/Type`.

    To be asked before a type that a bag names is imported: a bag may name anything.
    """
    if not _NAME.fullmatch(message_type):
        return False
    try:
        _find(message_type, ".msg")
    except DefinitionError:
        return False
    return True


def _find(message_type: str, suffix: str) -> Path:
    package, name = _split(message_type)
    for prefix in prefixes():
        path = prefix / "share" / package / "msg" / f"{name}{suffix}"
        if path.is_file():
            return path
    raise DefinitionError(f"no installed package defines {message_type}: {package} must be in AMENT_PREFIX_PATH")


@cache
def schema_text(message_type: str) -> str:
    """Return the definition of `message_type`, `package/msg/Type`, then those of all types it contains, each once.

    Raises DefinitionError if the type or one it contains is not installed.
    """
    texts: dict[str, str] = {}

    def visit(full: str) -> None:
        package, name = _split(full)
        key = f"{package}/{name}"
        if key in texts:
            return
        text = _find(key, ".msg").read_text(encoding="utf-8")
        texts[key] = text
        for field_type in (match["type"] for match in field_lines(text.splitlines())):
            if field_type not in PRIMITIVES:
                visit(field_type if "/" in field_type else f"{package}/{field_type}")

    visit(message_type)
    (_, first), *others = texts.items()
    return first + "".join(f"\n{SEPARATOR}\nMSG: {key}\n{text}" for key, text in others)


@cache
def type_hash(message_type: str) -> str:
    """Return the RIHS01 hash of `message_type`, `package/msg/Type`; empty if its package does not ship one."""
    package, name = _split(message_type)
    try:
        description = json.loads(_find(message_type, ".json").read_text(encoding="utf-8"))
    except DefinitionError:
        return ""
    hashes = {entry["type_name"]: entry["hash_string"] for entry in description["type_hashes"]}
    return str(hashes.get(f"{package}/msg/{name}", ""))
