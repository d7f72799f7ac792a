"""Who of the viewers of the page is in command: one at a time; another takes over."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from itertools import count


@dataclass
class CommandPost:
    """Viewers by number, in the order in which they came."""

    viewers: list[int] = field(default_factory=list)  # those that have the page open
    commander: int | None = None  # who is in command; None where nobody is
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
        return self.release(viewer)

    def take(self, viewer: int) -> int | None:
        """Give the command to a `viewer`; return who was in command before."""
        before = self.commander
        if viewer in self.viewers:
            self.commander = viewer
        return before

    def release(self, viewer: int) -> bool:
        """Let a `viewer` lay the command down; return whether it had it."""
        if viewer != self.commander:
            return False
        self.commander = None
        return True

    def words(self, viewer: int) -> str:
        """Say to a `viewer` who is in command."""
        who = "no viewer is" if self.commander is None else f"viewer {self.commander} is"
        return f"{'you are' if self.commander == viewer else who} in command; {len(self.viewers)} watching"
