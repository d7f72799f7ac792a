"""The page of one viewer: what it shows, four times a second, and the buttons."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any, NamedTuple

from heave_bags.analyse.verdict import open_loop
from heave_bringup.operate.situation import mode_words, run_words
from heave_bringup.operate.tasks import EmergencyStop
from heave_node.interface.alarm import Severity
from heave_node.interface.fault_kinds import FAULTS
from heave_node.kpi import efficiency
from nicegui import ui

from heave_panel.alarm_list import Alarm
from heave_panel.command_post import CommandPost
from heave_panel.history import HEAVE, LINES, TENSION, UNIT, WINCH
from heave_panel.operator_commands import COMMANDS, Command, devices_of, inject
from heave_panel.run_worker import Begin, Picture, RunWorker

PERIOD = 0.25
"""Wall time between two updates [s]."""
SILENCE = 0.8
"""Wall time without a word of the run, after which that is said [s]."""
CHARTS = (HEAVE, UNIT, WINCH, TENSION)
COLOURS = ("#56b4e9", "#e69f00")
FIGURES = (
    "efficiency, est. [%]",
    "load, est. [cm]",
    "load std. dev., est. [cm]",
    "boom tip, est. [m]",
    "rope at boom tip, est. [cm]",
    "depth, est. [m]",
    "tension [kN]",
)
SHOWN_ALARMS, SHOWN_LOG = 30, 8
SURE = "Sure? This acts on the winch or on its sensors."
BAR_LOOKS = ("text-sm", "text-lg font-bold", "heave-bad font-bold")

STYLE = """
<style>
body { background: #10161c; color: #dde5ec; }
.heave-bar { background: #17202a; border-bottom: 1px solid #2e3b47; z-index: 50; }
.heave-box { background: #17202a; border: 1px solid #2e3b47; border-radius: 6px; padding: .6rem .8rem; }
.heave-name { color: #9aabb9; font-size: .8rem; line-height: 1.1; }
.heave-value { font-size: 1.5rem; font-weight: 600; font-variant-numeric: tabular-nums; line-height: 1.3; }
.heave-good { color: #4cc9a0; } .heave-warn { color: #ffc04d; } .heave-bad { color: #ff8a80; }
.heave-use { height: 6px; background: #2e3b47; border-radius: 3px; overflow: hidden; }
.heave-use > div { height: 100%; background: #56b4e9; }
#lost { display: none; position: fixed; inset: 0 0 auto 0; z-index: 9999; background: #b00020; color: #fff;
  padding: .7rem 1rem; font-weight: 600; text-align: center; }
.heave-alarm { border-top: 1px solid #2e3b47; padding: .25rem 0; }
.nicegui-content { padding: 0; }
@media (min-width: 1024px) { .heave-page { grid-template-rows: auto 1fr; } }
@media (max-width: 560px) { .heave-value { font-size: 1.2rem; } }
</style>
"""
LOST = """
<div id="lost" role="alert">NO CONNECTION to the panel: the values shown are stale. The run goes on without it.
Emergency: press the button of the winch itself.</div>
<script>
(() => {
  let beat = "", heard = performance.now();
  setInterval(() => {
    const element = document.querySelector(".heave-beat");
    if (element && element.textContent !== beat) { beat = element.textContent; heard = performance.now(); }
    document.getElementById("lost").style.display = performance.now() - heard > 900 ? "block" : "none";
  }, 100);
})();
</script>
"""


Ask = Callable[[], Callable[[], tuple[Any, ...]]]
"""Builds fields of a dialog, and returns what reads them."""


class _Bar(NamedTuple):
    """Labels at the head: of the run, of the mode, and of what is wrong."""

    run: Any
    mode: Any
    word: Any


class Page:
    """The page of one viewer.

    Parameters
    ----------
    worker : has the link to the run
    post : who is in command
    place : ROS domain and namespace of the run, in words

    Attributes
    ----------
    viewer : number of the viewer; 0 before it has come
    """

    def __init__(self, worker: RunWorker, post: CommandPost, place: str) -> None:
        self._worker, self._post, self._place = worker, post, place
        self.viewer = 0
        self._beat = 0
        self._shown: dict[str, object] = {}
        self._buttons: list[Any] = []
        ui.add_head_html(STYLE)
        ui.add_body_html(LOST)
        ui.dark_mode(True)
        self._build_bar()
        with ui.element("main").classes("heave-page w-full p-3 grid grid-cols-1 lg:grid-cols-3 gap-3"):
            with ui.column().classes("lg:col-span-2 gap-3 w-full"):
                self._build_figures()
            with ui.column().classes("lg:row-span-2 gap-3 w-full"):  # on a telephone before the trends
                self._build_commands()  # above what grows, so that no button moves under a finger
                self._build_alarms()
                self._build_log()
            with ui.column().classes("lg:col-span-2 gap-3 w-full"):
                self._build_charts()
        ui.timer(PERIOD, self.refresh)

    # what is there

    def _build_bar(self) -> None:
        with ui.element("header").classes("heave-bar sticky top-0 w-full flex flex-wrap items-center gap-3 p-2 px-3"):
            with ui.column().classes("gap-0 grow min-w-0"):
                self._bar = _Bar(*(ui.label().classes(look) for look in BAR_LOOKS))
            ui.button("EMERGENCY STOP", on_click=self.stop_at_once, color="negative").props(
                "size=lg unelevated"
            ).classes("font-bold emergency max-sm:w-full")
        self._beating = ui.label().classes("heave-beat hidden")

    def _build_figures(self) -> None:
        self._figures: dict[str, Any] = {}
        with ui.element("section").classes("grid grid-cols-2 sm:grid-cols-4 gap-2 w-full"):
            for name in FIGURES:
                with ui.element("div").classes("heave-box"):
                    ui.label(name).classes("heave-name")
                    self._figures[name] = ui.label("-").classes("heave-value")
        with ui.element("section").classes("heave-box grid grid-cols-1 sm:grid-cols-3 gap-x-6 gap-y-1 w-full"):
            self._uses: dict[str, tuple[Any, Any]] = {}
            for name in ("winch speed", "winch acceleration", "payout"):
                with ui.column().classes("gap-1 w-full"):
                    label = ui.label(name).classes("text-sm")
                    with ui.element("div").classes("heave-use w-full"):
                        self._uses[name] = label, ui.element("div")

    def _build_charts(self) -> None:
        self._charts: dict[str, tuple[Any, list[int]]] = {}
        with ui.element("section").classes("grid grid-cols-1 xl:grid-cols-2 gap-3 w-full"):
            for chart in CHARTS:
                numbers = [number for number, line in enumerate(LINES) if line.chart == chart]
                with ui.element("div").classes("heave-box w-full"):
                    self._charts[chart] = ui.echart(_chart(chart, numbers)).classes("w-full h-48"), numbers

    def _build_commands(self) -> None:
        with ui.element("section").classes("heave-box w-full"):
            with ui.row().classes("items-center justify-between w-full"):
                self._command_words = ui.label().classes("text-sm grow")
                self._take = ui.button("take command", on_click=self._take_or_release).props("dense outline")
            self._build_buttons(command for command in COMMANDS if not command.is_of_simulation)
        with ui.element("section").classes("heave-box w-full"):
            ui.label("Simulation").classes("text-sm font-bold")
            with self._build_buttons(command for command in COMMANDS if command.is_of_simulation):
                inject = ui.button("inject", on_click=self._open_fault)
            self._buttons.append(inject.props("dense no-caps color=secondary"))

    def _build_buttons(self, commands: Iterable[Command]) -> ui.element:
        with ui.element("div").classes("grid grid-cols-3 gap-2 mt-2 w-full") as grid:
            for command in commands:
                colour = {"stop": "warning"}.get(command.name, "secondary" if command.is_of_simulation else "primary")
                button = ui.button(command.name, on_click=partial(self._open, command))
                self._buttons.append(button.props(f"dense no-caps color={colour}"))
        return grid

    def _build_alarms(self) -> None:
        with ui.element("section").classes("heave-box w-full"):
            ui.label("Alarms").classes("font-bold")
            self._alarms = ui.column().classes("gap-1 w-full")

    def _build_log(self) -> None:
        with ui.element("section").classes("heave-box w-full"):
            ui.label("What was requested").classes("font-bold")
            self._log = ui.column().classes("gap-0 w-full text-sm")

    # what is done

    def stop_at_once(self) -> None:
        """Stop in an emergency: every viewer may, in command or not, and nothing is asked."""
        self._worker.begin("EMERGENCY STOP", EmergencyStop, self.viewer)

    def arrive(self, tab: str) -> None:
        """Take note that a `tab` of a browser shows the page, for the first time or again."""
        if not self.viewer:
            self.viewer = self._post.join(tab)

    def leave(self) -> None:
        """Take note that the page is gone."""
        if self.viewer and self._post.leave(self.viewer):
            self._worker.let_go(self.viewer)

    def _take_or_release(self) -> None:
        """Lay the command down, or take it; from another viewer after a question."""
        other = self._post.commander
        if other == self.viewer:
            self._post.release(self.viewer)
        elif other is None:
            self._post.take(self.viewer)
        else:
            self._confirm("take command", f"Viewer {other} is in command. Take it over?", self._take_over)

    def _take_over(self) -> None:
        before = self._post.take(self.viewer)
        if before is not None:
            self._worker.let_go(before)

    def _begin(self, name: str, begin: Begin) -> None:
        if self._post.commander != self.viewer:
            ui.notify("you are not in command", type="negative")
            return
        self._worker.begin(name, begin, self.viewer)

    def _may_not(self) -> bool:
        """Return whether this viewer is not in command, and say so."""
        if self._post.commander != self.viewer:
            ui.notify("take command first", type="warning")
        return self._post.commander != self.viewer

    def _open(self, command: Command) -> None:
        """Ask for what the command needs, and whether it is meant; begin at once what needs neither."""
        if self._may_not():
            return

        def begin(text: str = "") -> None:
            self._begin(f"{command.name} {text}".strip(), lambda link: command.begin(link, text))

        if command.question or command.is_confirmed:
            words = SURE if command.is_confirmed else ""
            self._confirm(command.name, words, begin, partial(_text, command.question) if command.question else None)
        else:
            begin()

    def _open_fault(self) -> None:
        """Ask for device, kind, duration and magnitude of a fault; only what is simulated is offered."""
        devices = list(devices_of(self._worker.picture.situation))
        if self._may_not():
            return
        if not devices:
            ui.notify("nothing is simulated in this run: a fault can be injected nowhere", type="warning")
            return

        def begin(*fault: Any) -> None:
            self._begin(f"inject {fault[0]} {fault[1]}", lambda link: inject(link, *fault))

        self._confirm("inject", SURE, begin, partial(_fault, devices))

    def _confirm(
        self,
        name: str,
        words: str,
        do: Callable[..., None],
        ask: Callable[[], Callable[[], tuple[Any, ...]]] | None = None,
    ) -> None:
        """Ask whether something is meant before it is done.

        Parameters
        ----------
        name : of what is done
        words : the question; "": it is not asked
        do : does it, with what was given
        ask : builds the fields for what is to be given, and returns what reads them
        """
        with ui.dialog(value=True) as dialog, ui.card().classes("min-w-72"):
            ui.label(name).classes("text-lg font-bold")
            given = ask() if ask else tuple
            if words:
                ui.label(words).classes("text-sm")

            def begin() -> None:
                dialog.close()
                do(*given())

            with ui.row():
                ui.button("yes, do it" if words else "do it", on_click=begin).classes("confirm")
                ui.button("leave it", on_click=dialog.close).props("outline")
        dialog.on("hide", dialog.delete)

    # what is shown

    def refresh(self) -> None:
        """Show the newest."""
        picture = self._worker.picture
        self._beat += 1
        self._beating.text = str(self._beat)
        self._show_bar(picture)
        self._show_figures(picture)
        self._show_command(picture)
        self._show_alarms(picture)
        self._show_log(picture)
        if self._beat % 2:
            self._show_charts(picture)

    def _show_bar(self, picture: Picture) -> None:
        situation, bar = picture.situation, self._bar
        recorded = open_loop(situation.played)
        bar.run.text = f"{self._place}: {run_words(situation.run)}{recorded and f'; {recorded}'}"
        bar.mode.text = mode_words(situation.controller) if situation.controller else "no word from the controller"
        mode = situation.controller.mode if situation.controller else ""
        style = {"compensating": "heave-good", "constant_tension": "heave-good", "emergency_stop": "heave-bad"}
        bar.mode.classes(
            replace=f"text-lg font-bold {style.get(mode, 'heave-bad' if mode == 'stopped' else 'heave-warn')}"
        )
        words = f"NO WORD from the run for {picture.silence:.1f} s: the values shown are stale"
        bar.word.text = words if picture.silence > SILENCE and not situation.is_over else ""

    def _show_figures(self, picture: Picture) -> None:
        situation = picture.situation
        newest = {f"{line.name}": line.value(situation) for line in LINES}
        figures = situation.figures
        sigma, off = (figures.unit_sigma, figures.uncompensated_sigma) if figures else (math.nan, math.nan)
        for name, value, digits in zip(
            FIGURES,
            (
                100.0 * efficiency(sigma, off),
                newest["load"],
                100.0 * sigma,
                newest["boom tip"],
                newest["rope at the boom tip"],
                situation.depth,
                newest["tension"],
            ),
            (1, 1, 2, 2, 1, 2, 1),
            strict=True,
        ):
            # what rounds to zero has no sign
            self._figures[name].text = f"{round(value, digits) + 0.0:.{digits}f}" if math.isfinite(value) else "-"
        self._show_uses(picture)

    def _show_uses(self, picture: Picture) -> None:
        winch, limits = picture.situation.winch, picture.limits
        rate, acceleration, payout = (winch.rate, winch.acceleration, winch.payout) if winch else 3 * (math.nan,)
        span = limits.payout_maximum - limits.payout_minimum
        for name, text, share in (
            ("winch speed", f"{rate:+.2f} of {limits.speed:g} m/s", abs(rate) / limits.speed),
            (
                "winch acceleration",
                f"{acceleration:+.2f} of {limits.acceleration:g} m/s²",
                abs(acceleration) / limits.acceleration,
            ),
            (
                "payout",
                f"{payout:.2f} m, from {limits.payout_minimum:g} to {limits.payout_maximum:g} m",
                (payout - limits.payout_minimum) / span if span > 0.0 else math.nan,
            ),
        ):
            label, bar = self._uses[name]
            label.text = f"{name}: {text}".replace("nan", "?")
            width = 100.0 * min(max(share, 0.0), 1.0) if math.isfinite(share) else 0.0
            colour = "#ff8a80" if width > 95.0 else "#ffc04d" if width > 75.0 else "#56b4e9"
            bar.style(f"width: {width:.0f}%; background: {colour}")

    def _show_command(self, picture: Picture) -> None:
        post = self._post
        is_mine = post.commander == self.viewer
        self._command_words.text = post.words(self.viewer)
        self._take.text = "lay it down" if is_mine else "take command"
        for button in self._buttons:
            button.set_enabled(is_mine and not picture.situation.is_over)

    def _show_alarms(self, picture: Picture) -> None:
        shown = (picture.alarms, self._post.commander == self.viewer)
        if shown == self._shown.get("alarms"):
            return
        self._shown["alarms"] = shown
        self._alarms.clear()
        with self._alarms:
            if not picture.alarms:
                ui.label("none").classes("heave-good text-sm")
            for alarm in picture.alarms[:SHOWN_ALARMS]:
                self._show_alarm(alarm, may_acknowledge=shown[1])

    def _show_alarm(self, alarm: Alarm, *, may_acknowledge: bool) -> None:
        """Show an alarm: severity, time and title, what is wrong, what to do, and whether somebody has seen it."""
        with ui.row().classes("items-start no-wrap w-full gap-2 heave-alarm"):
            with ui.column().classes("grow gap-0 min-w-0 text-sm"):
                style = "heave-bad" if alarm.severity >= Severity.HIGH else "heave-warn"
                weight = "" if alarm.is_acknowledged else "font-bold"
                past = "" if alarm.is_active else " (ended)"
                when = f"{'before ' * alarm.is_older}{alarm.since:.1f} s"
                head = f"{alarm.severity.word.upper()} {when}: {alarm.title}{past}"
                ui.label(head).classes(f"{style} {weight}")
                ui.label(alarm.text).classes("break-words")
                if alarm.action:
                    ui.label(f"Action: {alarm.action}").classes("break-words font-medium")
            if may_acknowledge and not alarm.is_acknowledged:
                seen = partial(self._worker.acknowledge, alarm.key)
                ui.button("acknowledge", on_click=seen).props("dense flat size=sm no-caps")

    def _show_log(self, picture: Picture) -> None:
        shown = (picture.log[:SHOWN_LOG], picture.under_way)
        if shown == self._shown.get("log"):
            return
        self._shown["log"] = shown
        self._log.clear()
        with self._log:
            for name in picture.under_way:
                ui.label(f"under way: {name}").classes("heave-warn")
            for entry in picture.log[:SHOWN_LOG]:
                ui.label(f"{entry.time:.1f} s: {entry.text}").classes("heave-bad" if entry.is_refused else "")

    def _show_charts(self, picture: Picture) -> None:
        first, last = self._worker.history.span
        for chart, (element, numbers) in self._charts.items():
            options = element.options
            options["xAxis"]["min"], options["xAxis"]["max"] = first, last
            for place, number in enumerate(numbers):
                options["series"][place]["data"] = self._worker.history.series(number)
            if chart == WINCH and math.isfinite(picture.limits.speed):
                speed = picture.limits.speed
                options["series"][0]["markLine"]["data"] = [{"yAxis": speed}, {"yAxis": -speed}]
            element.update()


def _chart(title: str, numbers: list[int]) -> dict[str, Any]:
    """Return a chart of some LINES, by their numbers."""
    limit = {"silent": True, "symbol": "none", "lineStyle": {"color": "#ff8a80"}, "label": {"formatter": "limit"}}
    grey = {"color": "#9aabb9"}
    return {
        "animation": False,
        "title": {"text": title, "left": 0, "top": 0, "textStyle": {"fontSize": 12, **grey}},
        "legend": {"right": 0, "top": 0, "textStyle": grey, "itemHeight": 8, "icon": "roundRect"},
        "grid": {"left": 48, "right": 14, "top": 30, "bottom": 36},
        "xAxis": {
            "type": "value",
            "name": "simulated time [s]",
            "nameLocation": "middle",
            "nameGap": 22,
            "nameTextStyle": grey,
            "axisLabel": {"showMinLabel": False, "showMaxLabel": False, **grey},
            "splitLine": {"lineStyle": {"color": "#2e3b47"}},
        },
        "yAxis": {"type": "value", "scale": True, "axisLabel": grey, "splitLine": {"lineStyle": {"color": "#2e3b47"}}},
        "series": [
            {
                "type": "line",
                "name": LINES[number].name,
                "showSymbol": False,
                "lineStyle": {"width": 1.5},
                "color": COLOURS[place],
                "data": [],
                "markLine": {**limit, "data": []},
            }
            for place, number in enumerate(numbers)
        ],
    }


def _text(question: str) -> Callable[[], tuple[str]]:
    """Ask a `question` that a line of text answers; return what reads it."""
    given = ui.input(question).props("autofocus")
    return lambda: (str(given.value or "").strip(),)


def _fault(devices: list[str]) -> Callable[[], tuple[str, str, float, float]]:
    """Ask for one of the `devices`, and kind, duration [s] and magnitude of a fault; return what reads them."""
    device = ui.select(devices, label="device", value=devices[0]).classes("w-full")
    kind = ui.select([kind for kind in FAULTS if kind != "clear"], label="kind", value="freeze").classes("w-full")
    duration = ui.number("duration [s], 0: once, or until cleared", value=0.0, min=0.0).classes("w-full")
    magnitude = ui.number("magnitude, in the unit of the kind", value=0.0).classes("w-full")
    return lambda: (str(device.value), str(kind.value), duration.value or 0.0, magnitude.value or 0.0)
