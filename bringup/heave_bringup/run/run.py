"""Run a scenario: start the nodes, show how it goes, end them all, and say what became of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from heave_msgs.msg import TickStatus
from heave_node.ros.environment import prepare_environment
from heave_node.ros.shared_memory import remove_dead_segments
from heave_node.scenario import write_sections

from heave_bringup.errors import CommandError
from heave_bringup.nodes import MASTER, NODES, SHIP_CLOCK
from heave_bringup.progress import ProgressLine
from heave_bringup.run.launcher import Launcher, NodeProcess
from heave_bringup.run.monitor import Monitor
from heave_bringup.scenarios import Scenario
from heave_bringup.stored_scenario import stored_sections, stored_title

ANOTHER_RUN = "another run is under way in this ROS domain: end it, or set another ROS_DOMAIN_ID"

LOOK_PERIOD = 0.1
"""Wall time between two looks at the nodes [s]."""
END_NEWS_WAIT = 1.0
"""Wall time in which the master's word that the run is over may arrive after the first node has left for it [s]."""
SHUTDOWN_WAIT = 30.0
"""Wall time that the nodes have to end once the run is over [s]."""
STOP_RECORDING_TIME = 3.0
"""Real time: wall time for which a run goes on after a node died, so that the bag shows how the winch stops [s]."""


@dataclass
class RunFolder:
    """Where a run leaves its files.

    Attributes
    ----------
    path : the folder
    bag, report, scenario, logs : what lies in it
    """

    path: Path
    bag: Path = field(init=False)
    report: Path = field(init=False)
    scenario: Path = field(init=False)
    logs: Path = field(init=False)

    def __post_init__(self) -> None:
        self.bag = self.path / "bag"
        self.report = self.path / "report.html"
        self.scenario = self.path / "scenario.yaml"
        self.logs = self.path / "logs"


def new_run_folder(name: str, chosen: Path | None) -> RunFolder:
    """Return the folder of a run.

    Parameters
    ----------
    name : of the scenario
    chosen : folder that the user named; None takes the next free `runs/NAME-NNN`

    Raises CommandError where the chosen folder is not empty.
    """
    if chosen is not None:
        if chosen.exists() and any(chosen.iterdir()):
            raise CommandError(f"{chosen}: is not empty; name another folder or remove it")
        path = chosen
    else:
        number = 1
        while (path := Path("runs") / f"{name}-{number:03d}").exists():
            number += 1
    return RunFolder(path.resolve())


@dataclass(frozen=True)
class Outcome:
    """How a run went.

    Attributes
    ----------
    status : last status of the clock master
    alarms : errors that the nodes reported, in order
    """

    status: TickStatus
    alarms: list[str]


OnLook = Callable[[Launcher, "TickStatus | None"], None]


def run_scenario(
    scenario: Scenario,
    folder: RunFolder,
    *,
    substitutes: Mapping[str, Path] | None = None,
    on_look: OnLook | None = None,
) -> Outcome:
    """Run a scenario to its end and return how it went.

    Parameters
    ----------
    scenario : checked
    folder : where the run leaves its files
    substitutes : bags by the node in whose place each is played
    on_look : called a few times per second while the run lasts

    Raises CommandError, in one line, where the run does not reach its end. Whatever happens, no node process is left
    behind, and the bag is closed.
    """
    prepare_environment()
    remove_dead_segments()
    monitor = _listen()
    launcher = Launcher()
    progress = ProgressLine()
    try:
        if monitor.another_run():
            raise CommandError(ANOTHER_RUN)
        store_scenario(scenario, folder)
        launcher.start(nodes_to_start(scenario), folder.scenario, folder.logs, substitutes)
        status = _watch(scenario, folder, launcher, monitor, progress, on_look)
        return Outcome(status, monitor.alarms)
    except KeyboardInterrupt:
        raise CommandError(f"interrupted; {_where_to_look(folder)}") from None
    finally:
        progress.close()
        launcher.stop()
        monitor.close()


def _listen() -> Monitor:
    try:
        return Monitor()
    except RuntimeError as error:  # of rclpy: no keys in the keystore, no such middleware
        raise CommandError(f"ROS does not start: {' '.join(str(error).split())}") from None


def nodes_to_start(scenario: Scenario) -> list[str]:
    """Return the nodes that are not replaced by hardware or left out of the run."""
    wanted = {MASTER, *scenario.run.participants} - set(scenario.run.external)
    clock = [SHIP_CLOCK.name] if MASTER in scenario.run.external else []
    return clock + [node.name for node in NODES if node.name in wanted]


def store_scenario(scenario: Scenario, folder: RunFolder) -> None:
    """Write the parameter file that the nodes get and the bag carries: all values in force.

    Parameters
    ----------
    scenario : checked
    folder : of the run; the recorder is told to write into it
    """
    recorder = replace(
        scenario.parameters["recorder"],
        directory=str(folder.bag),
        scenario_file=str(folder.scenario),
        scenario=scenario.name,
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
    while True:
        monitor.spin(LOOK_PERIOD)
        if on_look is not None:
            on_look(launcher, monitor.status)
        _report_alarms(monitor, progress)
        _show_progress(scenario, monitor, progress)
        failed = launcher.failed() or _left_early(launcher, monitor)
        if failed:
            cause = _cause([node.how_it_ended() for node in failed], monitor)
            _record_the_stop(scenario, monitor)
            _report_alarms(monitor, progress)
            raise CommandError(f"{cause}; {_where_to_look(folder)}")
        if launcher.all_ended():
            break
        if monitor.is_over_for > SHUTDOWN_WAIT:
            raise CommandError(f"{', '.join(launcher.running())} did not end within {SHUTDOWN_WAIT:g} s after the run")
        if monitor.masters() > 1:  # on a busy machine it may show itself late
            raise CommandError(ANOTHER_RUN)
    status = monitor.status
    if status is None or status.state != TickStatus.ENDED:
        raise CommandError(f"the nodes ended, but the run was never reported as over; {_where_to_look(folder)}")
    return status


def _report_alarms(monitor: Monitor, progress: ProgressLine) -> None:
    for alarm in monitor.take_alarms():
        progress.tell(alarm)


def _where_to_look(folder: RunFolder) -> str:
    return f"the recording is in {folder.bag}, the logs of the nodes are in {folder.logs}"


def _left_early(launcher: Launcher, monitor: Monitor) -> list[NodeProcess]:
    """Return the nodes that ended without an error before the run was over."""
    if monitor.is_over or not launcher.left():
        return []
    monitor.spin_until_over(END_NEWS_WAIT)
    return [] if monitor.is_over else launcher.left()


def _record_the_stop(scenario: Scenario, monitor: Monitor) -> None:
    if not scenario.run.is_lockstep:
        monitor.spin(STOP_RECORDING_TIME)


def _cause(endings: Sequence[str], monitor: Monitor) -> str:
    """Return the line that says why a run failed: a node that was killed goes before those that only missed it."""
    killed = [text for text in endings if "was killed by" in text]
    cause = (killed or endings)[0]
    when = f" at t = {monitor.status.simulated_time:.2f} s" if monitor.status and " t = " not in cause else ""
    return cause + when


def _show_progress(scenario: Scenario, monitor: Monitor, progress: ProgressLine) -> None:
    status, kpi = monitor.status, monitor.kpi
    if status is None:
        progress.show("starting the nodes")
        return
    if status.state == TickStatus.WAITING:
        progress.show(f"waiting for {status.reason}")
        return
    duration = scenario.run.duration
    text = f"{status.simulated_time:7.1f} s of {duration:g} s  {status.real_time_factor:5.1f} x real time"
    if kpi is not None and status.simulated_time > kpi.window:  # before that the window holds the start-up
        text += f"  as estimated: unit sigma {100.0 * kpi.unit_sigma:.2f} cm"
        text += f"  efficiency {100.0 * kpi.unit_efficiency:.1f} %"
    progress.show(text, min(status.simulated_time / duration, 1.0) if duration else 1.0)
