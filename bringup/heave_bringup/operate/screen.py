"""The interactive screen: it listens to the run, takes keys and looks at tasks in one loop that never blocks."""

from __future__ import annotations

import os
import select
import sys
import termios
import tty
from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.live import Live

from heave_bringup.errors import CommandError
from heave_bringup.operate.keys import Keyboard
from heave_bringup.operate.link import RunLink
from heave_bringup.operate.situation import run_words
from heave_bringup.operate.tasks import Task
from heave_bringup.operate.view import View

LOOK_PERIOD = 0.02
"""Wall time between two looks at the keyboard [s]."""
DRAWING_PERIOD = 0.2
"""Wall time between two pictures [s]."""
ENDING_TIME = 1.0
"""Wall time in which what needs the operator ends when he leaves [s]."""


def operate_on_screen(link: RunLink, place: str) -> None:
    """Show the run of a `link` and take keys until the operator leaves or the run ends; `place` names the run.

    Leaving changes nothing of the run but what needs the operator: a speed that is asked for ends.

    Raises CommandError where there is no terminal.
    """
    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        raise CommandError(
            "without a verb there must be a terminal for the screen: see heave operate --help for the verbs"
        )
    view = View(place)
    console = Console()
    with _keys(sys.stdin.fileno()) as keyboard_file, Live(console=console, screen=True, auto_refresh=False) as live:
        _serve(link, view, live, keyboard_file)
    sys.stdout.write(f"{run_words(link.situation.run)}\n")


def _serve(link: RunLink, view: View, live: Live, keyboard_file: int) -> None:
    tasks: list[tuple[str, Task]] = []

    def begun(name: str, task: Task) -> None:
        tasks.append((name, task))

    keyboard = Keyboard(link, begun)
    drawn_at = 0.0
    while not keyboard.is_left and not link.situation.is_over:
        link.spin(LOOK_PERIOD)
        for key in pressed(keyboard_file):
            keyboard.press(key)
        _look_at(tasks, view)
        view.note(link.situation)
        if link.wall_time - drawn_at >= DRAWING_PERIOD:
            drawn_at = link.wall_time
            waiting = ", ".join(name for name, _ in tasks)
            picture = view.render(
                link.situation,
                prompt=keyboard.prompt or (f"under way: {waiting}" if waiting else ""),
                complaint=keyboard.complaint,
                silence=drawn_at - link.heard_at,
                width=live.console.width,
            )
            live.update(picture, refresh=True)
    for _, task in tasks:
        if not hasattr(task, "progress"):  # a move goes on without its operator, a speed does not
            task.cancel()
    link.spin(ENDING_TIME if tasks else 0.0)


def _look_at(tasks: list[tuple[str, Task]], view: View) -> None:
    """Take the answers that have come."""
    for entry in list(tasks):
        name, task = entry
        answer = task.poll()
        if answer is not None:
            tasks.remove(entry)
            view.tell(f"{name}: {answer.text}", is_refused=answer.is_refused)


def pressed(keyboard_file: int) -> Iterator[str]:
    """Yield the keys that were pressed since the last look; a key that sends several characters counts as none.

    Parameters
    ----------
    keyboard_file : descriptor of the terminal
    """
    if not select.select([keyboard_file], [], [], 0.0)[0]:
        return
    text = os.read(keyboard_file, 256).decode(errors="ignore")
    if not text:
        raise CommandError("the terminal is gone; the run goes on")
    if len(text) > 1 and text.startswith("\x1b"):  # an arrow or function key
        return
    yield from text


@contextmanager
def _keys(keyboard_file: int) -> Iterator[int]:
    """Let keys come one by one, without showing them; Ctrl-C works as ever."""
    before = termios.tcgetattr(keyboard_file)
    tty.setcbreak(keyboard_file)
    try:
        yield keyboard_file
    finally:
        termios.tcsetattr(keyboard_file, termios.TCSADRAIN, before)
