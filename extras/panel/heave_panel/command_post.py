"""Who of the viewers of the page is in command: one at a time, handed over by asking."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from itertools import count

ASKING_TIME = 30.0
"""Wall time after which a request for the command that nobody answers lapses [s]."""


@dataclass
class CommandPost:
    """Viewers by number, in the order in which they came."""

    viewers: list[int] = field(default_factory=list)  # those that have the page open
    commander: int | None = None  # who is in command; None where nobody is
    asking: int | None = None  # who asks for the command; None where nobody does
    _asked_at: float = 0.0
    _numbers: count[int] = field(default_factory=lambda: count(1))
    _viewer_of: dict[str, int] = field(default_factory=dict)
    _pages: Counter[int] = field(default_factory=Counter)

    def join(self, tab: str = "") -> int:
        """Let somebody watch in a `tab` of a browser; return the number of the viewer.

        A page that is loaded again in its tab is the same viewer, in command as before. "" is always another one.
        """
        viewer = self._viewer_of.get(tab) if tab else None
        if viewer not in self.viewers:
            viewer = next(self._numbers)
            self.viewers.append(viewer)
            self._viewer_of[tab] = viewer
        assert viewer is not None
        self._pages[viewer] += 1
        return viewer

    def leave(self, viewer: int) -> bool:
        """Let a page of a `viewer` go; return whether with it goes who was in command, which nobody is then."""
        self._pages[viewer] -= 1
        if self._pages[viewer] > 0:
            return False
        if viewer in self.viewers:
            self.viewers.remove(viewer)
        if self.asking == viewer:
            self.asking = None
        was_commander = self.commander == viewer
        if was_commander:
            self.commander, self.asking = self.asking, None
        return was_commander

    def ask(self, viewer: int, now: float) -> None:
        """Let a `viewer` ask for the command at a wall time `now` [s]; it has it at once where nobody is in command."""
        if viewer not in self.viewers:
            return
        if self.commander is None:
            self.commander, self.asking = viewer, None
        elif viewer != self.commander and self.asking is None:
            self.asking, self._asked_at = viewer, now

    def answer(self, viewer: int, *, hands_over: bool) -> None:
        """Let the `viewer` in command answer the one that asks: it `hands_over`, or keeps the command."""
        if viewer == self.commander and self.asking is not None:
            if hands_over:
                self.commander = self.asking
            self.asking = None

    def release(self, viewer: int) -> None:
        """Let the `viewer` in command lay it down; who asks for it has it then."""
        if viewer == self.commander:
            self.commander, self.asking = self.asking, None

    def lapse(self, now: float) -> None:
        """Drop a request that nobody has answered in time, at a wall time `now` [s]."""
        if self.asking is not None and now - self._asked_at > ASKING_TIME:
            self.asking = None

    def words(self, viewer: int) -> str:
        """Say to a `viewer` who is in command."""
        watching = f"{len(self.viewers)} watching"
        if self.commander is None:
            return f"no viewer is in command; {watching}"
        if self.commander == viewer:
            asks = f"viewer {self.asking} asks for it; " if self.asking is not None else ""
            return f"you are in command; {asks}{watching}"
        asks = "; you have asked for it" if self.asking == viewer else ""
        return f"viewer {self.commander} is in command{asks}; {watching}"
