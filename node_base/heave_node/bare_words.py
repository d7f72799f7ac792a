"""Bare words: what ROS 2 reads in place of a word in a parameter file that is not in quotes.

>>> read_bare("off"), read_bare("nan"), read_bare("freeze")
(False, nan, 'freeze')
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress

_TRUTHS = {
    **dict.fromkeys(("y", "yes", "on", "true"), True),
    **dict.fromkeys(("n", "no", "off", "false"), False),
}


def read_bare(word: str) -> bool | int | float | str:
    """Return what a bare `word` of a file is read as: a truth value, a number, or the word itself.

    ROS 2 (`rcl_yaml_param_parser`) takes the truth values in three spellings, `on`, `On` and `ON`, and as numbers what
    C reads as such, `nan` and `infinity` among them. A few words more are taken for numbers here (`1_000`).
    """
    if word.lower() in _TRUTHS:
        return _TRUTHS[word.lower()]
    with suppress(ValueError):
        return int(word, 0)
    with suppress(ValueError):
        return float(word.lower().replace(".nan", "nan").replace(".inf", "inf"))
    return word


def word_meant(value: object, words: Sequence[str]) -> str:
    """Return which of the `words` somebody wrote bare that is now read as a `value`; "" for none of them.

    Parameters
    ----------
    value : as read from a file or an option
    words : that are allowed
    """
    return next((word for word in words if _is_same(read_bare(word), value)), "")


def _is_same(one: object, other: object) -> bool:
    if isinstance(one, float) and isinstance(other, float) and math.isnan(one):
        return math.isnan(other)
    return type(one) is type(other) and one == other
