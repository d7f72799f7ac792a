"""`heave check`: a live external node held against its contract."""

from __future__ import annotations

import argparse
import math

from heave_node.parameters import ParameterError
from heave_node.tick.clock_rule import parse_clock

from heave_bringup.commands.arguments import add_namespace, add_network
from heave_bringup.errors import VerdictError

SUMMARY = "Check a live external node against the contract; a winch is braked and released, never moved."
EXAMPLES = ("heave check --external virtual_winch", "heave check --external wave_vessel=own")

REPLACEABLE = ("winch_controller", "virtual_winch", "wave_vessel", "cable_sim")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    parser.add_argument(
        "--external",
        required=True,
        metavar="NODE[=CLOCK]",
        help=f"node of the suite that the external node replaces: {', '.join(REPLACEABLE)}; CLOCK is the clock of its "
        "stamps: simulated, own, none; detected if not given",
    )
    parser.add_argument("--seconds", type=float, default=4.0, metavar="S", help="duration of each phase (default: 4)")
    add_namespace(parser, "the node is in namespace NAME")
    add_network(parser)


def execute(options: argparse.Namespace) -> None:
    """Listen as `options` say, print the table and the verdict."""
    from heave_bringup.external.contract import CONTRACT_OF
    from heave_bringup.external.live_check import check_node
    from heave_bringup.network import set_up_transport
    from heave_bringup.output import make_table, write_result

    if not (math.isfinite(options.seconds) and options.seconds >= 2.0):
        raise ParameterError(f"--seconds {options.seconds:g}: must be at least 2")
    node, stamping = parse_clock(options.external if "=" in options.external else f"{options.external}=detect")
    if node not in REPLACEABLE:
        raise ParameterError(f"--external {node}: must be one of {', '.join(REPLACEABLE)}")
    set_up_transport(network=options.network)
    findings = check_node(CONTRACT_OF[node], options.seconds, stamping.rule, options.namespace or "")
    wrong = [finding for finding in findings if not finding.is_good]
    rows = [[f.topic, f.what, "ok" if f.is_good else "WRONG", f.words] for f in findings]
    verdict = (
        f"verdict: FAILED; {len(wrong)} of {len(findings)} do not keep the contract"
        if wrong
        else "verdict: passed; the contract is kept"
    )
    write_result(
        options,
        [make_table(("topic", "what", "result", "found"), rows, texts=("what", "result", "found")), verdict],
        {"external": node, "good": not wrong, "findings": [vars(finding) for finding in findings]},
    )
    if wrong:
        raise VerdictError([f"{node}: {one.topic}: {one.what}" for one in wrong], "the table above")
