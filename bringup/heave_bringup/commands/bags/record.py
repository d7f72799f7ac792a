"""`heave record`: a stand-alone recorder, beside any other program."""

from __future__ import annotations

import argparse
from pathlib import Path

from heave_node.parameters import ParameterError

from heave_bringup.commands.arguments import add_network
from heave_bringup.errors import CommandError

SUMMARY = "Record all topics, of any type, until Ctrl-C; for use on a ship or beside other programs."
EXAMPLES = ("heave record sea_trial --set split_duration=600.0",)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    parser.add_argument("directory", metavar="DIR", type=Path, help="folder of the bag; it must not exist yet")
    parser.add_argument(
        "--set", action="append", default=[], metavar="PARAM=VALUE", help="change a parameter of the recorder"
    )
    add_network(parser)


def execute(options: argparse.Namespace) -> None:
    """Record until Ctrl-C and say what the bag holds, as `options` say."""
    from heave_bags.mcap.reader import Bag
    from heave_bags.record.live_recorder import record

    from heave_bringup.network import set_up_transport
    from heave_bringup.output import write_result

    set_up_transport(network=options.network)
    arguments = ["heave", "--ros-args", "-p", f"directory:={options.directory}"]
    for setting in options.set:
        name, separator, value = setting.partition("=")
        if not separator:
            raise ParameterError(f"--set {setting}: must be PARAM=VALUE, for example split_duration=600.0")
        arguments += ["-p", f"{name}:={value}"]
    status = record(arguments)
    bag = Bag(options.directory)
    text = f"{bag.path}: {bag.message_count} messages on {len(bag.topics)} topics, {bag.duration:.1f} s"
    write_result(options, text, {"bag": str(bag.path), "messages": bag.message_count, "topics": len(bag.topics)})
    if status:
        raise CommandError(f"{bag.path}: the recording is incomplete; see above")
