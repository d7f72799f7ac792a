"""What an operator requests of the controller, as it is reported and read back: one table for both."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import NamedTuple

MODE, DEPTH, HOLD, SPEED, NO_SPEED, FACTOR, DESIGN = "mode", "depth", "hold", "speed", "no speed", "factor", "design"

FORMS: Mapping[str, tuple[str, ...]] = {
    MODE: ("mode {}", " at {:.7g} N"),
    DEPTH: ("depth {:.7g} m", " at {:.7g} m/s"),
    HOLD: ("hold",),
    SPEED: ("speed {:+.7g} m/s",),
    NO_SPEED: ("no speed",),
    FACTOR: ("factor {:.7g}",),
    DESIGN: ("design for waves of {!r} m", " and {!r} s", " with {!r} m of cable"),
}
"""Words of each kind of request, by what is stated; of the last ones not all need be."""


def stated(value: float) -> float:
    """Return a requested `value` as it is reported, and obeyed: a record then gives the same request again."""
    return float(f"{value:.7g}") + 0.0  # no -0


class Request(NamedTuple):
    """A request."""

    kind: str  # one of FORMS
    # mode and tension to hold [N]; depth [m] and speed [m/s]; speed, positive lowers [m/s]; factor [-]; significant
    # wave height [m], peak period [s] and cable length [m] of a design
    values: tuple[str | float, ...] = ()

    @property
    def words(self) -> str:
        """The request in words, without a comma."""
        # a name may be anything that somebody has sent
        values = [re.sub(r"\W", "_", value) if isinstance(value, str) else value for value in self.values]
        parts = FORMS[self.kind][: max(len(values), 1)]
        return "".join(part.format(*values[n : n + 1]) for n, part in enumerate(parts))


def request_of(words: str) -> Request | None:
    """Return the request in `words`, of which remarks may follow after a colon; None where they are none."""
    for kind, parts in FORMS.items():
        first, *others = (re.sub(r"\\{.*?\\}", r"(\\S+)", re.escape(part)) for part in parts)
        found = re.fullmatch(first + "".join(f"(?:{part})?" for part in others), words.split(": ", maxsplit=1)[0])
        if found is None:
            continue
        values = [value for value in found.groups() if value is not None]
        try:
            return Request(kind, tuple(values[:1] if kind == MODE else ()) + tuple(map(float, values[kind == MODE :])))
        except ValueError:
            return None
    return None
