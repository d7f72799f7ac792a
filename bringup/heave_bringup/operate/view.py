"""What the screen shows of a situation: run, mode, trends, alarms, what was requested, and the keys."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from rich import box
from rich.columns import Columns
from rich.console import Group, RenderableType
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from heave_bringup.operate.keys import COMMANDS, QUIT
from heave_bringup.operate.situation import Situation, mode_words, run_words
from heave_bringup.operate.trend import Trend

TREND_STEP = 0.5
"""Simulated time of one bar [s]."""
TREND_LENGTH = 240
LOG_LENGTH = 6
"""Answers that stay on the screen."""
SILENCE = 1.0
"""Wall time without a word of the clock master after which that is said [s]."""
SHOWN_ALARMS = 6

MODE_STYLE = {"compensating": "bold green", "constant_tension": "bold green", "manual": "bold yellow"}
STOPPED_STYLE, CHANGING_STYLE = "bold white on red", "bold yellow"


@dataclass(frozen=True)
class Signal:
    """A signal that is drawn.

    Attributes
    ----------
    name, unit : on the screen
    scale : of the SI value in that unit
    value : of a situation, SI; NaN where it is not known
    """

    name: str
    unit: str
    scale: float
    value: Callable[[Situation], float]


def _of_controller(name: str) -> Callable[[Situation], float]:
    return lambda situation: math.nan if situation.controller is None else float(getattr(situation.controller, name))


def _of_winch(name: str) -> Callable[[Situation], float]:
    return lambda situation: math.nan if situation.winch is None else float(getattr(situation.winch, name))


SIGNALS: tuple[Signal, ...] = (
    Signal("boom tip, est.", "m", 1.0, _of_controller("boom_tip_heave")),
    Signal("winch locked, est.", "m", 1.0, _of_controller("uncompensated_heave")),
    Signal("unit, est.", "cm", 100.0, _of_controller("unit_heave")),
    Signal("payout", "m", 1.0, _of_winch("payout")),
    Signal("payout rate", "m/s", 1.0, _of_winch("rate")),
    Signal("tension", "kN", 1e-3, lambda situation: situation.tension),
)


class View:
    """What the operator sees.

    Parameters
    ----------
    place : ROS domain and namespace of the run, in words
    """

    def __init__(self, place: str) -> None:
        self._place = place
        self._trends = [Trend(TREND_STEP, TREND_LENGTH) for _ in SIGNALS]
        self._log: deque[Text] = deque(maxlen=LOG_LENGTH)

    def note(self, situation: Situation) -> None:
        """Take a `situation` into the trends."""
        for signal, trend in zip(SIGNALS, self._trends, strict=True):
            value = signal.value(situation)
            if math.isfinite(value):
                trend.note(situation.time, signal.scale * value)

    def tell(self, text: str, *, is_refused: bool = False) -> None:
        """Keep a `text` in the list of answers; `is_refused` ones stand out."""
        self._log.append(Text(text, style="red" if is_refused else ""))

    def render(
        self, situation: Situation, *, prompt: str = "", complaint: str = "", silence: float = 0.0, width: int = 80
    ) -> RenderableType:
        """Return the screen.

        Parameters
        ----------
        situation : known now
        prompt, complaint : of the keyboard
        silence : wall time since the clock master was heard [s]
        width : of the terminal, in columns
        """
        parts: list[RenderableType] = [_header(situation, silence), self._figures(situation, width), _alarms(situation)]
        if self._log:
            parts.append(Group(*self._log))
        parts.append(_foot(prompt, complaint))
        return Panel(Group(*parts), title=f"heave operate: {self._place}", box=box.ROUNDED)

    def _figures(self, situation: Situation, width: int) -> Table:
        table = Table(box=None, pad_edge=False, show_header=True, header_style="dim")
        for heading, justify in (("", "left"), ("now", "right"), ("lowest", "right"), ("highest", "right")):
            table.add_column(heading, justify=justify, no_wrap=True)  # type: ignore[arg-type]
        table.add_column("", no_wrap=True, overflow="crop")
        for signal, trend in zip(SIGNALS, self._trends, strict=True):
            low, high = trend.extent
            now = signal.scale * signal.value(situation)
            table.add_row(
                Text(f"{signal.name} [{signal.unit}]"),
                *(_figure(value) for value in (now, low, high)),
                trend.draw(max(width - 56, 10)),
            )
        return table


def _figure(value: float) -> str:
    return f"{value:.2f}" if math.isfinite(value) else "-"


def _header(situation: Situation, silence: float) -> Group:
    lines = [Text(run_words(situation.run), style="yellow" if situation.is_paused else "")]
    if silence > SILENCE:
        lines.append(Text(f"NO WORD from the run for {silence:.0f} s: the values shown are stale", style=STOPPED_STYLE))
    controller, winch = situation.controller, situation.winch
    if controller is not None:
        style = MODE_STYLE.get(controller.mode, CHANGING_STYLE)
        if controller.mode in ("stopped", "emergency_stop"):
            style = STOPPED_STYLE
        lines.append(Text(mode_words(controller), style=style))
        if controller.limits:
            lines.append(Text(f"at limits: {', '.join(controller.limits)}", style="yellow"))
    words = [f"mean depth {situation.depth:.2f} m"] if math.isfinite(situation.depth) else []
    if winch is not None:
        words.append(f"brake {'ON' if winch.brake else 'off'}")
    if situation.figures is not None and math.isfinite(situation.figures.unit_sigma):
        figures = situation.figures
        heave = f"{100.0 * figures.unit_sigma:.2f} cm over {figures.window:.0f} s"
        words.append(f"unit heave, standard deviation {heave}, est.")
    return Group(*lines, Text("; ".join(words)), Text(""))


def _alarms(situation: Situation) -> Group:
    troubles = sorted(situation.troubles.values(), key=lambda trouble: not trouble.is_error)
    lines = [Text(str(one), style="bold red" if one.is_error else "yellow") for one in troubles[:SHOWN_ALARMS]]
    if len(troubles) > SHOWN_ALARMS:
        lines.append(Text(f"and {len(troubles) - SHOWN_ALARMS} more", style="yellow"))
    return Group(Text(""), *(lines or [Text("no alarm", style="green")]), Text(""))


def _foot(prompt: str, complaint: str) -> Group:
    names = [(command.key, command.name) for command in COMMANDS] + [(QUIT, "leave")]
    keys = Columns([Text.assemble((key, "bold cyan"), f" {name}") for key, name in names], padding=(0, 2))
    stop = Text(" SPACE: EMERGENCY STOP ", style=STOPPED_STYLE)
    lines: list[RenderableType] = [Text(""), keys, stop]
    if prompt:
        lines.append(Text(prompt, style="bold"))
    elif complaint:
        lines.append(Text(complaint, style="red"))
    return Group(*lines)
