"""A field of a message by its path, as in `pose.pose.position.z`, `data[0]` or `position[name=drum]`.

The last form picks, of an array, the entry at which the array `name` beside it holds the word `drum`, as joint states
have it. Works on every object with attributes, so on messages of any type that is installed.
"""

from __future__ import annotations

import math
import re
from typing import Any

_STEP = re.compile(r"(?P<name>[A-Za-z_]\w*)(\[(?P<index>\d+)\]|\[(?P<key>[A-Za-z_]\w*)=(?P<word>[^\]]+)\])?")


class FieldPath:
    """A path to a field.

    Parameters
    ----------
    text : the path

    Raises ValueError where it is none.
    """

    def __init__(self, text: str) -> None:
        self.text = text
        self._steps = []
        for part in _split(text):
            found = _STEP.fullmatch(part)
            if found is None:
                raise ValueError(
                    f"{text!r} is no path of a field, such as pose.pose.position.z, data[0], position[name=drum]"
                )
            self._steps.append(found)

    def of(self, message: Any) -> Any:
        """Return what a `message` holds there. Raises LookupError, in words, where it has no such field or entry."""
        for step in self._steps:
            holder, message = message, getattr(message, step["name"], None)
            if message is None:
                raise LookupError(f"there is no field {self.text}")
            if step["index"] is None and step["key"] is None:
                continue
            index = int(step["index"]) if step["index"] is not None else self._place(holder, step)
            if not 0 <= index < len(message):
                raise LookupError(f"{self.text}: the array has {len(message)} entries")
            message = message[index]
        return message

    def number_of(self, message: Any) -> float:
        """Return the number that a `message` holds there. Raises LookupError where it is none, or is not finite."""
        value = self.of(message)
        try:
            value = float(value)
        except (TypeError, ValueError):
            raise LookupError(f"{self.text} is no number") from None
        if not math.isfinite(value):
            raise LookupError(f"{self.text} is {value:g}")
        return float(value)

    def put(self, message: Any, value: float) -> None:
        """Write a `value` into a `message` at this path; an array grows to the entry.

        Raises LookupError where it has no such field.
        """
        *way, last = self._steps
        holder = FieldPath(".".join(step[0] for step in way)).of(message) if way else message
        held = getattr(holder, last["name"], None)
        if held is None:
            raise LookupError(f"there is no field {self.text}")
        if last["index"] is None:
            setattr(holder, last["name"], type(held)(value))
            return
        entries = [float(entry) for entry in held]
        entries += [0.0] * (int(last["index"]) + 1 - len(entries))
        entries[int(last["index"])] = value
        setattr(holder, last["name"], entries)

    def _place(self, holder: Any, step: re.Match[str]) -> int:
        names = list(getattr(holder, step["key"], ()))
        if step["word"] not in names:
            raise LookupError(
                f"{self.text}: {step['key']} has no {step['word']}; it has {', '.join(map(str, names)) or 'none'}"
            )
        return names.index(step["word"])


def _split(text: str) -> list[str]:
    """Return the parts of a path between points that stand outside brackets."""
    return re.split(r"\.(?![^\[]*\])", text)
