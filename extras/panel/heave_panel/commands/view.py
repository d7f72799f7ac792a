"""`heave view`: a live stream of a run for Foxglove."""

from __future__ import annotations

import argparse
import importlib.util
import sys

from heave_bringup.commands.arguments import add_namespace, add_network, port_number
from heave_bringup.errors import CommandError
from heave_node.extras import missing_extra

SUMMARY = "Stream a run or a replayed bag to Foxglove on this machine; Foxglove needs no ROS."
EXAMPLES = (
    "heave view",
    "heave view --port 8766",
    "heave replay runs/b2_calm_300-001/bag --loop    # in another terminal: the view shows the bag",
)

DEFAULT_PORT = 8765
"""Port that Foxglove offers by default."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    parser.add_argument("--port", type=port_number, default=DEFAULT_PORT, help=f"default: {DEFAULT_PORT}")
    add_namespace(parser, "the run is in namespace NAME")
    add_network(parser)


def execute(options: argparse.Namespace) -> None:
    """Serve the stream on this machine until Ctrl-C, as `options` say."""
    if importlib.util.find_spec("foxglove") is None:
        raise CommandError(str(missing_extra("heave view", "panel")))
    from heave_bringup.network import set_up_transport

    from heave_panel.view.stream import Stream, layout_file

    set_up_transport(network=options.network)
    stream = Stream(options.namespace or "", options.port)
    layout = layout_file()
    sys.stdout.write(f"view      ws://localhost:{options.port}: in Foxglove, open a connection, Foxglove WebSocket\n")
    if layout is not None:
        sys.stdout.write(f"layout    {layout}: import it there\n")
    sys.stdout.write("Ctrl-C ends the view; the run goes on\n")
    sys.stdout.flush()
    stream.serve()
