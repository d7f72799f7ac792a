"""`heave adapt`: devices of others in a run, by map files."""

from __future__ import annotations

import argparse
import math
import sys
import time
from typing import TYPE_CHECKING

from heave_bringup.commands.arguments import add_namespace, add_network
from heave_bringup.errors import CommandError, ExitStatus, VerdictError
from heave_node.parameters import ParameterError

if TYPE_CHECKING:
    from heave_devices.adapt.session import Session
    from heave_devices.bench.wiggle import Verdict
    from heave_devices.maps.device_map import DeviceMap

SUMMARY = "Connect a third-party sensor or winch using a mapping file: serial, UDP, TCP, Modbus/TCP, OPC UA, ROS."
EXAMPLES = (
    "heave adapt --list",
    "heave adapt --show psxn > my_mru.yaml",
    "heave adapt my_winch.yaml --wiggle 20        # out by 20 mm and back: are signs and units right?",
    "heave adapt my_mru.yaml my_load_cell.yaml    # in another terminal: heave run ... --replace wave_vessel=external",
)


class IncompleteError(CommandError):
    """The command did what it says, and somebody has to look before there is a verdict."""

    status = ExitStatus.VERDICT_FAILED


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    parser.add_argument("maps", metavar="MAP", nargs="*", help="map file, or a shipped one (--list)")
    parser.add_argument("--list", action="store_true", help="list the shipped maps")
    parser.add_argument("--show", metavar="NAME", help="print a shipped map, to be saved and edited")
    parser.add_argument(
        "--check", action="store_true", help="check the maps and print what they do, without opening a device"
    )
    parser.add_argument(
        "--wiggle",
        type=float,
        metavar="MM",
        help="move the winch by MM millimetres and back, and check signs and units",
    )
    parser.add_argument(
        "--seen",
        nargs="+",
        default=[],
        choices=("direction", "fault", "reset"),
        help="of --wiggle: what you have tried by hand and found right, since no move shows it",
    )
    parser.add_argument("--duration", type=float, default=math.inf, metavar="S", help="stop after S seconds")
    add_namespace(parser, "the run is in namespace NAME")
    add_network(parser)


def execute(options: argparse.Namespace) -> None:
    """List, show or check maps, or serve devices until Ctrl-C, as `options` say."""
    from heave_bringup.output import make_table, write_result

    from heave_devices.adapt.shipped import find_map, shipped_maps, title_of

    known = shipped_maps()
    if options.list:
        rows = [[name, title_of(path)] for name, path in known.items()]
        write_result(options, make_table(("map", "for"), rows, texts=("for",)), dict(rows))
        return
    if options.show is not None:
        if options.show not in known:
            raise ParameterError(f"--show {options.show}: is no shipped map; known: {', '.join(known)}")
        write_result(options, known[options.show].read_text(encoding="utf-8"), {"map": options.show})
        return
    if not options.maps:
        raise ParameterError("name a map file, or a shipped map: heave adapt --list")
    maps = [find_map(name) for name in options.maps]
    published = [topic for device in maps for topic in device.outputs]
    twice = next((topic for topic in published if published.count(topic) > 1), None)
    if twice is not None:
        raise ParameterError(f"{twice} is published by more than one of the maps: a topic has one publisher")
    if options.check:
        rows = [[device.name, _from(device), ", ".join(device.outputs), ", ".join(device.channels)] for device in maps]
        titles = ("map", "from", "publishes", "quantities")
        write_result(
            options, make_table(titles, rows, texts=titles), [dict(zip(titles, row, strict=True)) for row in rows]
        )
        return
    _serve(options, maps)


def _serve(options: argparse.Namespace, maps: list[DeviceMap]) -> None:
    """Serve the devices of `maps` until Ctrl-C, and print what came."""
    from heave_bringup.network import set_up_transport
    from heave_bringup.output import write_result

    from heave_devices.adapt.report import figures_of, stale_words, summary_table
    from heave_devices.adapt.session import Session
    from heave_devices.bench.wiggle import check_wiggle

    if not options.duration > 0.0:
        raise ParameterError(f"--duration {options.duration:g}: must be above 0")
    set_up_transport(network=options.network)
    if options.wiggle is not None:
        check_wiggle(maps, 1e-3 * options.wiggle)
    session = Session(maps, options.namespace or "")
    if options.wiggle is not None:
        _wiggle(options, session)
        return
    for device in maps:
        sys.stderr.write(f"{device.name}: {_from(device)} to {', '.join(device.outputs)}\n")
    session.run(options.duration)
    result = {device.device.name: figures_of(device) for device in session.devices}
    write_result(options, summary_table(session.devices), result)
    silent = [device for device in session.devices if not sum(device.adapter.published.values())]
    if silent:
        raise CommandError(f"{silent[0].device.name}: {silent[0].problem or stale_words(silent[0], time.monotonic())}")


def _wiggle(options: argparse.Namespace, session: Session) -> None:
    """Move the winch of a `session`, and print what was found.

    Raises VerdictError where its map is wrong, and IncompleteError where that is not yet known.
    """
    from heave_bringup.output import make_table, write_result

    from heave_devices.bench.wiggle import wiggle

    moved = session.alone(lambda winch, spin: wiggle(winch, spin, 1e-3 * options.wiggle))
    found = [
        one._replace(is_tried=True, words="seen by you") if one.what in options.seen and not one.is_tried else one
        for one in moved
    ]
    rows = [[verdict.what, _judgement(verdict), verdict.words] for verdict in found]
    titles = ("quantity", "verdict", "found")
    write_result(options, make_table(titles, rows, texts=titles), [verdict._asdict() for verdict in found])
    wrong = [f"{verdict.what}: not as the map says" for verdict in found if not verdict.is_good]
    if wrong:
        raise VerdictError(wrong, "the table above")
    untried = [verdict.what for verdict in found if not verdict.is_tried]
    if untried:
        raise IncompleteError(
            f"verdict INCOMPLETE: {', '.join(untried)}: no move shows it. Try it by hand; once it is right, "
            f"repeat with --seen {' '.join(untried)}"
        )
    sys.stderr.write("verdict: passed; signs and units are right\n")


def _judgement(verdict: Verdict) -> str:
    return ("ok" if verdict.is_good else "WRONG") if verdict.is_tried else "not tried"


def _from(device: DeviceMap) -> str:
    return str(device.link or ", ".join(device.topics) or "a record")
