"""Run a scenario: start the nodes, show how it goes, end them all, and say what became of it."""

from __future__ import annotations

import itertools
import signal
import threading
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path

from cable_sim_node.line.step import advance
from heave_bags.analyse.verdict import open_loop
from heave_msgs.msg import TickStatus
from heave_node.numerics.compiled import is_compiled
from heave_node.parameters import ParameterError
from heave_node.ros.master import STOP_RECORDING_TIME
from heave_node.ros.transport.environment import prepare_environment
from heave_node.ros.transport.forked import Forked
from heave_node.ros.transport.watchdog import Watchdog, watched_start
from heave_node.scenario import write_sections

from heave_bringup.errors import AnotherRunError, CommandError, InterruptedCommandError
from heave_bringup.interrupts import raise_if_interrupted
from heave_bringup.network import ANOTHER_RUN, only_run_in_domain
from heave_bringup.nodes import ADVISER, MASTER, NODE_BY_NAME, RECORDER, nodes_to_start
from heave_bringup.progress import ProgressLine
from heave_bringup.replacements import Replacements
from heave_bringup.run.launcher import Launcher, NodeProcess
from heave_bringup.run.monitor import Monitor
from heave_bringup.scenarios import STORED, Scenario
from heave_bringup.stored_scenario import stored_sections, stored_title

RUNS = "runs"
"""Folder of all runs, unless the user names another."""

STARTING = "starting the nodes"
COMPILING = f"{STARTING}; compiling the plant, once after installation or an update: two to four minutes"
LOOK_PERIOD = 0.1
"""Wall time between two looks at the nodes [s]."""
END_NEWS_WAIT = 1.0
"""Wall time in which the master's word that the run is over may arrive after the first node has left for it [s]."""
SHUTDOWN_WAIT = 30.0
"""Wall time that the nodes have to end once the run is over [s]. By then a node that the middleware holds up has ended
itself; one that still runs is ended, and the run fails unless its recorder has closed the bag."""


@dataclass
class RunFolder:
    """Where a run leaves its files."""

    path: Path  # the folder
    bag: Path = field(init=False)  # what lies in it
    report: Path = field(init=False)  # what lies in it
    scenario: Path = field(init=False)  # what lies in it
    logs: Path = field(init=False)  # what lies in it

    def __post_init__(self) -> None:
        self.bag = self.path / "bag"
        self.report = self.path / "report.html"
        self.scenario = self.path / STORED
        self.logs = self.path / "logs"


def new_run_folder(name: str, chosen: Path | None) -> RunFolder:
    """Return the folder of a run of the scenario `name`: the `chosen` one, or else the next free `runs/NAME-NNN`.

    It is made at once: of two runs that begin together only one can have it. Raises ParameterError where the chosen
    folder is not empty.
    """
    if chosen is not None:
        if chosen.is_dir() and any(chosen.iterdir()):
            raise ParameterError(f"{chosen}: is not empty; choose another folder or remove it")
        try:
            chosen.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ParameterError(f"{chosen}: cannot be made: {error.strerror}; choose another folder") from error
        return RunFolder(chosen.resolve())
    for number in itertools.count(1):
        path = Path(RUNS) / f"{name}-{number:03d}"
        with suppress(FileExistsError):
            path.mkdir(parents=True)
            break
    return RunFolder(path.resolve())


@dataclass(frozen=True)
class Outcome:
    """How a run went."""

    status: TickStatus  # last status of the clock master
    strangers: list[str]  # processes that published where only others may; none of them was obeyed

    @property
    def lost(self) -> list[str]:
        """Messages that did not come to a node, or not to the bag: the figures hold for what did."""
        return [self.status.reason] if self.status.reason else []


@dataclass(frozen=True)
class Composed:
    """All nodes of a run share one process; `is_public` says that other processes get every message, not only a glance
    of each topic.
    """

    is_public: bool = False


OnLook = Callable[[Launcher, "TickStatus | None"], None]


def run_scenario(
    scenario: Scenario,
    folder: RunFolder,
    *,
    replaced: Replacements | None = None,
    on_look: OnLook | None = None,
    namespace: str = "",
    composed: Composed | None = None,
    forks: list[Forked] | None = None,
) -> Outcome:
    """Run a scenario to its end and return how it went.

    Parameters
    ----------
    scenario : checked
    folder : where the run leaves its files
    replaced : what takes the places of nodes. Where another program takes part in lockstep in the place of the plant,
        the ship's clock leads the ticks
    on_look : called a few times per second while the run lasts
    namespace : of its nodes and topics; "" for none. Runs in different ones share a ROS domain
    composed : all nodes share one process, and none is replaced; None: each has its own
    forks : processes that wait, for nodes to be started in; those that are used leave the list

    Raises CommandError, in one line, where the run does not reach its end. Whatever happens, no node process is left
    behind, and the bag is closed.
    """
    prepare_environment()
    replaced = replaced or Replacements()
    if MASTER in replaced.lockstep:  # it takes part in each tick, as others do, and does not lead them
        run = replace(scenario.run, participants=(*scenario.run.participants, MASTER))
        scenario = replace(scenario, run=run)
    with (
        only_run_in_domain(namespace) as is_only,
        watched_start() as watchdog,
        interrupts_noted() as was_interrupted,
    ):
        if not is_only:
            _remove_unused(folder)
            raise AnotherRunError(ANOTHER_RUN)
        monitor = _listen(namespace, is_open_loop=bool(open_loop(replaced.played)))
        launcher = Launcher(forks)
        progress = ProgressLine()
        try:
            if monitor.another_run():
                _remove_unused(folder)
                raise AnotherRunError(ANOTHER_RUN)
            store_scenario(scenario, folder, replaced.entries)
            names = nodes_to_start(scenario.run, replaced.lockstep)
            if composed is None:
                launcher.start(names, folder.scenario, folder.logs, replaced.programs, namespace)
            else:
                public = composed.is_public
                launcher.start_composed(names, folder.scenario, folder.logs, namespace, is_public=public)
            for node in launcher.nodes:
                watchdog.end_too(node.process.pid)
            look = _until_started(watchdog, was_interrupted, on_look)
            status = _watch(scenario, folder, launcher, monitor, progress, look)
            watchdog.will_say(f"the nodes are done, and ROS did not come back; {_where_to_look(folder)}")
            return Outcome(status, list(monitor.strangers))
        except CommandError as error:
            watchdog.will_say(str(error))
            raise
        except KeyboardInterrupt:
            raise InterruptedCommandError(f"interrupted; {_where_to_look(folder)}") from None
        finally:
            with interrupts_skip_grace(launcher):
                progress.close()
                launcher.stop()
                monitor.close()


def _until_started(watchdog: Watchdog, was_interrupted: threading.Event, on_look: OnLook | None) -> OnLook:
    """Return what is to be called at each look: it lets the `watchdog` know when the clock master is heard, and raises
    KeyboardInterrupt where the run was interrupted.
    """
    has_started = False

    def look(launcher: Launcher, status: TickStatus | None) -> None:
        nonlocal has_started
        if was_interrupted.is_set():
            raise KeyboardInterrupt
        if status is None:
            watchdog.beat()
        elif not has_started:
            has_started = True
            watchdog.has_started()
        if on_look is not None:
            on_look(launcher, status)

    return look


def _remove_unused(folder: RunFolder) -> None:
    """Remove the folder of a run that never began, and that of all runs where it has no other."""
    with suppress(OSError):  # not empty: it was there before
        folder.path.rmdir()
        if folder.path.parent == Path(RUNS).resolve():
            folder.path.parent.rmdir()


@contextmanager
def interrupts_noted() -> Iterator[threading.Event]:
    """Give what Ctrl-C and SIGTERM set meanwhile: an exception would be lost in a callback of the middleware."""
    raise_if_interrupted()
    was_interrupted = threading.Event()
    with _handled_by(lambda *_: was_interrupted.set()):
        yield was_interrupted


@contextmanager
def interrupts_skip_grace(launcher: Launcher) -> Iterator[None]:
    """Let a further Ctrl-C, while the nodes of a launcher end, end them at once in place of leaving them behind."""
    with _handled_by(launcher.skip_grace):
        yield


@contextmanager
def _handled_by(handler: Callable[..., object]) -> Iterator[None]:
    before = {number: signal.signal(number, handler) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, previous in before.items():
            signal.signal(number, previous)


def _listen(namespace: str, *, is_open_loop: bool) -> Monitor:
    try:
        return Monitor(namespace, is_open_loop=is_open_loop)
    except RuntimeError as error:  # of rclpy: no keys in the keystore, no such middleware
        raise CommandError(f"ROS failed to start: {' '.join(str(error).split())}") from None


def store_scenario(scenario: Scenario, folder: RunFolder, replaced: Sequence[str] = ()) -> None:
    """Write the parameter file of a checked `scenario` that the nodes get and the bag carries, all active values, into
    the `folder` of the run.

    What is `replaced` is the nodes in whose place a bag (NODE=bag) or another program takes part.
    """
    recorder = replace(
        scenario.parameters["recorder"],
        directory=str(folder.bag),
        scenario_file=str(folder.scenario),
        scenario=scenario.name,
        replaced=(*scenario.run.external, *replaced),
    )
    stored = replace(scenario, parameters={**scenario.parameters, "recorder": recorder})
    sections = stored_sections(stored)
    folder.path.mkdir(parents=True, exist_ok=True)
    write_sections(sections, folder.scenario, title=stored_title(scenario))


def _watch(
    scenario: Scenario,
    folder: RunFolder,
    launcher: Launcher,
    monitor: Monitor,
    progress: ProgressLine,
    on_look: OnLook | None,
) -> TickStatus:
    given_up: set[str] = set()
    while True:
        monitor.spin(LOOK_PERIOD)
        if on_look is not None:
            on_look(launcher, monitor.status)
        _report_news(monitor, progress)
        _show_progress(scenario, monitor, progress)
        for node in _ended_beside_the_loop(scenario, launcher, monitor):
            if node.name not in given_up:
                given_up.add(node.name)
                progress.tell(f"{node.how_it_ended()}: the run continues without it")
        failed = [node for node in launcher.failed() if node.name not in given_up]
        failed = failed or _left_early(launcher, monitor, given_up)
        if failed:
            monitor.spin_until_over(END_NEWS_WAIT)  # the master may know why
            cause = _cause(failed, monitor)
            _record_the_stop(scenario, monitor)
            _report_news(monitor, progress)
            raise CommandError(f"{cause}; {_where_to_look(folder)}")
        if launcher.all_ended():
            break
        if monitor.is_over_for > SHUTDOWN_WAIT:
            held_up = f"{', '.join(launcher.running())} did not exit within {SHUTDOWN_WAIT:g} s after the run"
            if not launcher.has_left(RECORDER):
                raise CommandError(f"{held_up}; {_where_to_look(folder)}")
            progress.tell(f"{held_up} and is ended; the bag is complete")
            break
    status = monitor.status
    if status is None or status.state != TickStatus.ENDED:
        raise CommandError(f"the nodes exited, but the run was never reported as finished; {_where_to_look(folder)}")
    return status


def _report_news(monitor: Monitor, progress: ProgressLine) -> None:
    for news in monitor.take_news():
        progress.tell(news)


def _where_to_look(folder: RunFolder) -> str:
    recording = f"the recording is in {folder.bag}" if folder.bag.exists() else "nothing was recorded yet"
    return f"{recording}, the logs of the nodes are in {folder.logs}"


def _ended_beside_the_loop(scenario: Scenario, launcher: Launcher, monitor: Monitor) -> list[NodeProcess]:
    """Return the nodes that ended during a real-time run that nobody waits for: the loop goes on without them."""
    is_under_way = monitor.status is not None and monitor.status.state != TickStatus.WAITING and not monitor.is_over
    if not is_under_way or scenario.run.is_lockstep:
        return []
    return [node for node in [*launcher.failed(), *launcher.left()] if node.name == ADVISER]


def _left_early(launcher: Launcher, monitor: Monitor, given_up: Collection[str]) -> list[NodeProcess]:
    """Return the nodes that ended without an error before the run was over, but for those `given_up`."""
    left = [node for node in launcher.left() if node.name not in given_up]
    if monitor.is_over or not left:
        return []
    monitor.spin_until_over(END_NEWS_WAIT)
    return [] if monitor.is_over else left


def _record_the_stop(scenario: Scenario, monitor: Monitor) -> None:
    if not scenario.run.is_lockstep:
        monitor.spin(STOP_RECORDING_TIME)


def _cause(failed: Sequence[NodeProcess], monitor: Monitor) -> str:
    """Return the line that says why a run failed.

    A node that was killed goes before those that only missed it, then a node's own report, then whom the clock
    master missed. What the recorder did not get is the last of the consequences.
    """
    endings = {node.name: node.how_it_ended() for node in failed}
    killed = [text for text in endings.values() if "was killed by" in text]
    own = [text for name, text in endings.items() if name not in (MASTER, RECORDER)]
    status = monitor.status
    missed = [_reason(status)] if status and status.state == TickStatus.FAILED and status.reason else []
    cause = next(iter([*killed, *own, *missed, *endings.values()]))
    # before the first tick there is no time to tell
    time = monitor.status.simulated_time if monitor.status else 0.0
    return cause if time == 0.0 or " t = " in cause else f"{cause} at t = {time:.2f} s"


def _reason(status: TickStatus) -> str:
    """Return what the clock master says; where it passes on the words of a node that has failed, as that one's."""
    is_of_node = status.reason.partition(":")[0] in NODE_BY_NAME
    return status.reason if is_of_node else f"{MASTER}: {status.reason}"


def _show_progress(scenario: Scenario, monitor: Monitor, progress: ProgressLine) -> None:
    status, kpi = monitor.status, monitor.kpi
    if status is None:
        has_plant = MASTER not in scenario.run.external
        progress.show(COMPILING if has_plant and not is_compiled(advance) else STARTING)
        return
    if status.state == TickStatus.WAITING:
        progress.show(f"waiting for {status.reason or 'the nodes to answer'}")
        return
    duration = scenario.run.duration
    factor = f"{status.real_time_factor:5.1f} x{'' if progress.is_narrow else ' real time'}"
    pace = "paused" if status.state == TickStatus.PAUSED else factor
    text = f"{status.simulated_time:7.1f} of {duration:g} s  {pace}"
    # before that the window holds the start-up
    is_known = kpi is not None and status.simulated_time > kpi.window
    estimated = (kpi.unit_sigma, kpi.unit_efficiency, kpi.window) if kpi is not None and is_known else ()
    text += f"  {monitor.live.words(*estimated)}"
    share = min(status.simulated_time / duration, 1.0) if duration else 1.0
    progress.show(text, None if progress.is_narrow else share)
