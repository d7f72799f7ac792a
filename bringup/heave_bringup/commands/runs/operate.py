"""`heave operate`: what an operator does to a run that is under way in another terminal, in one line."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from heave_node.interface.fault_kinds import FAULTS, faults_of
from heave_node.parameters import ParameterError

from heave_bringup.commands.arguments import add_namespace, add_network
from heave_bringup.errors import CommandError

if TYPE_CHECKING:
    from heave_bringup.operate.link import DepthMove, RunLink
    from heave_bringup.operate.moves import MoveBy
    from heave_bringup.operate.requests import Answer, Task

SUMMARY = "Operate a run from another terminal: status, mode, moves, gain, stop, faults."
EXAMPLES = (
    "heave operate status",
    "heave operate depth 295 --speed 0.2",
    "heave operate fault inject mru freeze --duration 10",
    "heave operate emergency-stop",
)

MODES = ("standby", "compensating", "constant_tension", "manual", "stopped", "emergency_stop")
"""Modes that can be requested."""
MOST = 1e6
"""Largest magnitude of a number that an operator gives; what is allowed is the controller's to say."""
OF_ITS_OWN_KIND = ("mru", "encoder", "winch")
"""Devices with faults of their own; all others have those of a sensor."""
LISTENING_TIME = 1.5
"""Wall time in which controller and winch of a run that is not paused are heard [s]."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`: a verb with arguments of its own."""
    _add_shared(parser)
    verbs = parser.add_subparsers(dest="verb", metavar="VERB", required=True)

    def verb(name: str, help_: str, example: str = "") -> argparse.ArgumentParser:
        one = verbs.add_parser(
            name,
            help=help_,
            description=f"{help_[0].upper()}{help_[1:]}.",
            epilog=f"example: heave operate {example or name}",
        )
        one.add_argument(
            "--json", metavar="FILE", default=argparse.SUPPRESS, help="write the answer as JSON; - for standard output"
        )
        _add_shared(one, default=argparse.SUPPRESS)
        return one

    verb("status", "print one line of status")
    _add_mode(verb("mode", "request a mode of the controller", "mode compensating"))
    depth = verb(
        "depth", "move the load to a mean depth and wait until it is there; Ctrl-C ends the move smoothly", "depth 295"
    )
    depth.add_argument("depth", type=_number(), metavar="D", help="depth [m], positive down")
    _add_move(depth)
    move = verb(
        "move", "move the load up or down from where it hangs, and wait until it is there", "move -2 --speed 0.1"
    )
    move.add_argument("by", type=_number(), metavar="BY", help="positive lowers [m]")
    _add_move(move)
    verb("hold", "end a move smoothly; compensation continues")
    speed = verb("speed", "lower or lift at a constant speed, like a joystick", "speed -0.1 --for 5")
    speed.add_argument("speed", type=_number(), metavar="V", help="positive lowers [m/s]")
    speed.add_argument(
        "--for", dest="seconds", type=_number(0.0), default=2.0, metavar="S", help="simulated time (default: 2)"
    )
    factor = verb("factor", "set the compensation gain, 0 to 1", "factor 0.5")
    factor.add_argument("factor", type=_number(0.0, 1.0), metavar="F", help="0 to 1")
    stop = verb("stop", "fade out compensation, stop the winch and apply the brake; wait until done")
    stop.add_argument("--no-wait", action="store_true", help="return as soon as the stop is accepted")
    verb("emergency-stop", "apply the brake at once; wait until the drum has stopped")
    _add_redesign(verb("redesign", "redesign the controller without stopping", "redesign --height 2.5 --period 9"))
    _add_fault(verb("fault", "inject or clear a fault in a simulated device", "fault inject mru freeze --duration 10"))
    verb("pause", "pause the simulation")
    verb("resume", "resume the simulation")
    step = verb("step", "advance a paused simulation by some cycles", "step 20")
    step.add_argument("ticks", type=_count, nargs="?", default=1, metavar="N", help="cycles (default: 1)")
    snapshot = verb("snapshot", "save the last seconds of the run as a separate bag", "snapshot --seconds 30")
    snapshot.add_argument(
        "--seconds", type=_number(0.0), default=0.0, metavar="S", help="length (default: everything kept)"
    )
    snapshot.add_argument(
        "--directory", type=Path, metavar="DIR", help="folder for the bag (default: beside that of the run)"
    )


def _add_shared(parser: argparse.ArgumentParser, default: str | None = None) -> None:
    add_namespace(parser, "the run is in namespace NAME", default)
    add_network(parser, default)


def _add_mode(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("mode", choices=MODES)
    parser.add_argument(
        "--tension", type=_number(0.0), default=0.0, metavar="N", help="tension to hold in constant_tension [N]"
    )
    parser.add_argument(
        "--unproved",
        action="store_true",
        help="compensate although neither load cell nor depth sensor has confirmed the MRU",
    )


def _add_move(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--speed", type=_number(0.0), default=0.0, metavar="V", help="maximum speed [m/s] (default: the controller's)"
    )
    parser.add_argument("--no-wait", action="store_true", help="return as soon as the move has started")


def _add_redesign(parser: argparse.ArgumentParser) -> None:
    for name, unit, means in (
        ("height", "m", "significant wave height (default: as estimated)"),
        ("period", "s", "peak period (default: as estimated)"),
        ("length", "m", "deployed cable length (default: the present one)"),
    ):
        parser.add_argument(f"--{name}", type=_number(0.0), default=0.0, metavar=unit.upper(), help=f"{means} [{unit}]")


def _add_fault(parser: argparse.ArgumentParser) -> None:
    from heave_node.interface.sensors import SENSORS

    devices = (*SENSORS, "crane", "encoder", "winch")
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    inject = actions.add_parser(
        "inject",
        help="inject a fault, from the next cycle on",
        epilog=_kinds_of_faults(),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    inject.add_argument("device", choices=devices)
    inject.add_argument("kind", choices=[kind for kind in FAULTS if kind != "clear"])
    inject.add_argument(
        "--duration",
        type=_number(0.0),
        default=0.0,
        metavar="S",
        help="simulated time (default: once, or until cleared)",
    )
    inject.add_argument(
        "--magnitude", type=_number(), default=0.0, metavar="X", help="in the unit of the kind of fault"
    )
    clear = actions.add_parser("clear", help="clear the faults of one device or of all")
    clear.add_argument("device", choices=(*devices, "all"))


def _kinds_of_faults() -> str:
    """Return the kinds of fault that each device can have, and what each kind is."""
    devices = (*((name, name) for name in OF_ITS_OWN_KIND), ("any other", "sensor"))
    of_device = [f"  {name:10} {', '.join(_kinds(device))}" for name, device in devices]
    kinds = [
        f"  {kind:15} {fault.words}" + (f"; magnitude: {fault.magnitude}" if fault.magnitude else "")
        for kind, fault in FAULTS.items()
        if kind != "clear"
    ]
    return "\n".join(["kinds of fault, by device:", *of_device, "", "what each does:", *kinds])


def _check_fault(options: argparse.Namespace) -> None:
    """Refuse, before a run is looked for, a fault that its device cannot have; raises ParameterError."""
    if options.verb != "fault" or options.action != "inject":
        return
    from heave_node.interface.faults import FaultParameters, FaultSchedule

    device = options.device if options.device in OF_ITS_OWN_KIND else "sensor"
    try:
        schedule = FaultSchedule(FaultParameters(), name=options.device, device=device)
        schedule.inject(options.kind, start=0.0, duration=options.duration, magnitude=options.magnitude)
    except ValueError as error:
        raise ParameterError(str(error)) from error


def _kinds(device: str) -> list[str]:
    return [kind for kind in faults_of(device) if kind != "clear"]


def _number(least: float = -MOST, most: float = MOST) -> Callable[[str], float]:
    def number(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not (math.isfinite(value) and least <= value <= most):
            raise argparse.ArgumentTypeError(f"{text}: must be a number from {least:g} to {most:g}")
        return value

    return number


def _count(text: str) -> int:
    value = int(text) if text.isascii() and text.isdigit() else 0
    if not 1 <= value <= MOST:
        raise argparse.ArgumentTypeError(f"{text}: must be a whole number of at least 1")
    return value


def execute(options: argparse.Namespace) -> None:
    """Do what `options` say to the run in this ROS domain."""
    from heave_bringup.network import set_up_transport
    from heave_bringup.operate.link import RunLink

    _check_fault(options)
    set_up_transport(network=options.network)
    link = RunLink(options.namespace or "")
    try:
        if options.verb == "status":
            _report_status(options, link)
        else:
            _report_answer(options, _do(options, link))
    finally:
        link.close()


def _report_status(options: argparse.Namespace, link: RunLink) -> None:
    from dataclasses import asdict

    from heave_bringup.operate.situation import status_line
    from heave_bringup.output import write_result

    link.listen(LISTENING_TIME)
    situation = link.situation
    if not situation.is_paused and not math.isfinite(situation.depth):
        link.spin(LISTENING_TIME)  # alarms and depth are reported once per simulated second
    write_result(options, status_line(situation), asdict(situation))


def _report_answer(options: argparse.Namespace, answer: Answer) -> None:
    from heave_bringup.output import write_result

    if options.json or not answer.is_refused:
        write_result(options, answer.text, {"verb": options.verb, "done": not answer.is_refused, "answer": answer.text})
    if answer.is_refused:
        raise CommandError(answer.text)


def _do(options: argparse.Namespace, link: RunLink) -> Answer:
    """Do what the verb says, and return the answer."""
    task = _task(options, link)
    if options.verb in ("depth", "move"):
        return _follow(task, link, waits=not options.no_wait)  # type: ignore[arg-type]
    return link.finish(task)


def _task(options: argparse.Namespace, link: RunLink) -> Task:
    from heave_bringup.operate import moves, requests, tasks

    begin: dict[str, Callable[[], Task]] = {
        "mode": lambda: link.start(requests.request_mode(options.mode, options.tension, unproved=options.unproved)),
        "depth": lambda: link.start_move(options.depth, options.speed),
        "move": lambda: moves.MoveBy(link, options.by, options.speed),
        "hold": link.cancel_moves,
        "speed": lambda: moves.Lowering(link, options.speed, options.seconds),
        "factor": lambda: link.start(requests.request_factor(options.factor)),
        "stop": lambda: link.start(requests.request_mode("stopped")) if options.no_wait else tasks.Stop(link),
        "emergency-stop": lambda: tasks.EmergencyStop(link),
        "redesign": lambda: link.start(requests.request_redesign(options.height, options.period, options.length)),
        "fault": lambda: _fault(options, link),
        "pause": lambda: tasks.ClockTask(link, is_paused=True),
        "resume": lambda: tasks.ClockTask(link),
        "step": lambda: tasks.ClockTask(link, ticks=options.ticks),
        "snapshot": lambda: link.start(requests.request_snapshot(options.seconds, options.directory)),
    }
    return begin[options.verb]()


def _fault(options: argparse.Namespace, link: RunLink) -> Task:
    from heave_bringup.operate.requests import NODE_OF_DEVICE, request_fault
    from heave_bringup.operate.tasks import AnyOf

    if options.action == "inject":
        return link.start(request_fault(options.device, options.kind, options.duration, options.magnitude))
    devices = list(NODE_OF_DEVICE) if options.device == "all" else [options.device]
    return AnyOf([link.start(request_fault(device, "clear")) for device in devices])


def _follow(move: DepthMove | MoveBy, link: RunLink, *, waits: bool) -> Answer:
    """Show how a move goes until it has ended or, where nobody `waits` for that, is under way."""
    from heave_bringup.operate.moves import Followed
    from heave_bringup.progress import ProgressLine

    with ProgressLine() as line:

        def show(depth: float, rate: float, time_to_go: float) -> None:
            line.show(f"mean depth {depth:.2f} m at {rate:+.3f} m/s, {time_to_go:.0f} s to go")

        return link.finish(Followed(move, show, waits=waits))
