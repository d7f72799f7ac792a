"""`heave panel`: an operator's page in a browser for a run that is under way."""

from __future__ import annotations

import argparse
import importlib.util

from heave_bringup.commands.arguments import add_namespace, add_network, port_number
from heave_bringup.errors import CommandError
from heave_node.extras import missing_extra

SUMMARY = "Serve an operator's page in the browser for a run in another terminal."
EXAMPLES = ("heave panel", "heave panel --port 8090", "heave panel --host 0.0.0.0")

DEFAULT_PORT = 8080


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    parser.add_argument(
        "--host",
        default="127.0.0.1",
        help="address to serve the page on (default: this machine only); other machines need the printed token",
    )
    parser.add_argument("--port", type=port_number, default=DEFAULT_PORT, help=f"default: {DEFAULT_PORT}")
    add_namespace(parser, "the run is in namespace NAME")
    add_network(parser)


def execute(options: argparse.Namespace) -> None:
    """Serve the page until Ctrl-C, as `options` say."""
    if importlib.util.find_spec("nicegui") is None:  # an installed ROS 2 does not bring it
        raise CommandError(str(missing_extra("heave panel", "panel")))
    from heave_bringup.network import set_up_transport
    from heave_bringup.operate.link import RunLink

    from heave_panel.server import listen, serve

    set_up_transport(network=options.network)
    with listen(options.host, options.port) as listener:
        serve(RunLink(options.namespace or ""), listener, options.host)
