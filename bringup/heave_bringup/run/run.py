"""Run a scenario: start the nodes, show how it goes, end them all, and say what became of it."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from heave_msgs.msg import TickStatus
from heave_node.ros.environment import prepare_environment
from heave_node.ros.shared_memory import remove_dead_segments
from heave_node.scenario import NodeValues, write_scenario

from heave_bringup.errors import CommandError
from heave_bringup.progress import ProgressLine
from heave_bringup.run.launcher import Launcher, NodeProcess
from heave_bringup.run.monitor import Monitor
from heave_bringup.run.node_table import MASTER, NODES
from heave_bringup.scenarios import Scenario

ANOTHER_RUN = "another run is under way in this ROS domain: end it, or set another ROS_DOMAIN_ID"

LOOK_PERIOD = 0.1
"""Wall time between two looks at the nodes [s]."""
DESERTION = 1.0
"""Wall time in which the news that a run is over may come after the first node that left for it [s]."""
PARTING = 30.0
"""Wall time that the nodes have to end once the run is over [s]."""
AFTERMATH = 3.0
"""Real time: wall time that goes on after a node died, so that the bag shows how the winch stops [s]."""


@dataclass
class RunFolder:
    """Where a run leaves its files."""

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
    """Choose the folder of a run: the chosen one, or the next free `runs/NAME-NNN`. Raises CommandError where it is
    taken.
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
    status : the master's last word
    alarms : what the nodes called an error meanwhile, in order
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
    """Run a scenario to its end and return how it went; raise CommandError, in one line, where it does not reach it.

    Whatever happens, no node process is left behind and the bag is closed by then. `substitutes` names nodes in whose
    place a bag is played; `on_look` is called a few times per second while the run lasts.
    """
    prepare_environment()
    remove_dead_segments()
    monitor = _listen()
    launcher = Launcher()
    progress = ProgressLine()
    try:
        if monitor.another_run():
            raise CommandError(ANOTHER_RUN)
        folder.path.mkdir(parents=True, exist_ok=True)
        write_scenario(resolved(scenario, folder), folder.scenario)
        launcher.start(nodes_to_start(scenario), folder.scenario, folder.logs, substitutes)
        status = _watch(scenario, folder, launcher, monitor, progress, on_look)
        return Outcome(status, monitor.alarms)
    except KeyboardInterrupt:
        raise CommandError(f"interrupted; {_what_is_left(folder)}") from None
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
    return [node.name for node in NODES if node.name in wanted]


def resolved(scenario: Scenario, folder: RunFolder) -> NodeValues:
    """Return the scenario with the folder's paths in it: the file that the nodes get and the bag carries."""
    values = {node: dict(section) for node, section in scenario.values.items()}
    values.setdefault("recorder", {}).update(
        directory=str(folder.bag), scenario_file=str(folder.scenario), scenario=scenario.name
    )
    return values


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
        _tell_alarms(monitor, progress)
        progress.show(_progress_text(scenario, monitor))
        failed = launcher.failed() or _deserters(launcher, monitor)
        if failed:
            cause = _cause([node.obituary() for node in failed], monitor)
            _let_the_bag_show_it(scenario, monitor)
            _tell_alarms(monitor, progress)
            raise CommandError(f"{cause}; {_what_is_left(folder)}")
        if launcher.all_ended():
            break
        if monitor.is_over_for > PARTING:
            raise CommandError(f"{', '.join(launcher.running())} did not end within {PARTING:g} s after the run")
        if monitor.masters() > 1:  # on a busy machine it may show itself late
            raise CommandError(ANOTHER_RUN)
    status = monitor.status
    if status is None or status.state != TickStatus.ENDED:
        raise CommandError("the nodes ended without saying that the run was over; see the logs")
    return status


def _tell_alarms(monitor: Monitor, progress: ProgressLine) -> None:
    for alarm in monitor.take_alarms():
        progress.tell(alarm)


def _what_is_left(folder: RunFolder) -> str:
    return f"what was recorded is in {folder.bag}, what the nodes said in {folder.logs}"


def _deserters(launcher: Launcher, monitor: Monitor) -> list[NodeProcess]:
    """Return the nodes that left, as if all were well, before the run was over."""
    if monitor.is_over or not launcher.left():
        return []
    monitor.spin_until_over(DESERTION)
    return [] if monitor.is_over else launcher.left()


def _let_the_bag_show_it(scenario: Scenario, monitor: Monitor) -> None:
    if not scenario.run.is_lockstep:
        monitor.spin(AFTERMATH)


def _cause(obituaries: Sequence[str], monitor: Monitor) -> str:
    """Return the line that tells why a run failed: a node that was killed goes before those that only missed it."""
    killed = [text for text in obituaries if "was killed by" in text]
    cause = (killed or obituaries)[0]
    time_of_death = f" at t = {monitor.status.simulated_time:.2f} s" if monitor.status and " t = " not in cause else ""
    return cause + time_of_death


def _progress_text(scenario: Scenario, monitor: Monitor) -> str:
    status, kpi = monitor.status, monitor.kpi
    if status is None:
        return "starting the nodes"
    if status.state == TickStatus.WAITING:
        return f"waiting for {status.reason}"[: shutil.get_terminal_size().columns - 1]
    share = status.simulated_time / scenario.run.duration if scenario.run.duration else 1.0
    text = f"{status.simulated_time:7.1f} s of {scenario.run.duration:g} s ({min(share, 1.0):4.0%})"
    text += f"  {status.real_time_factor:5.1f} x real time"
    if kpi is not None and status.simulated_time > kpi.window:  # before that the window holds the start-up
        text += f"  as estimated: unit sigma {100.0 * kpi.unit_sigma:.2f} cm"
        text += f"  efficiency {100.0 * kpi.unit_efficiency:.1f} %"
    return text
