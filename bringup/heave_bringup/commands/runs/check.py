"""`heave check`: a live external node held against its contract."""

from __future__ import annotations

import argparse
import math

from heave_node.parameters import ParameterError
from heave_node.tick.clock_rule import parse_clock

from heave_bringup.commands.arguments import add_namespace, add_network
from heave_bringup.errors import VerdictError
from heave_bringup.nodes import ADVISER
from heave_bringup.replacements import EXTERNAL, OPTION, add_replace, parse_replacements

SUMMARY = "Check a running external node against the contract. A winch is braked and released, never moved."
EXAMPLES = ("heave check --replace virtual_winch=external", "heave check --replace mru=external:own")

REPLACEABLE = ("winch_controller", "virtual_winch", "wave_vessel", "cable_sim")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    add_replace(
        parser,
        f"what the external node replaces: {', '.join(REPLACEABLE)}, or the topic of one sensor, such as mru; CLOCK is "
        "the clock of its stamps: simulated, own, none; detected if not given",
        f"{EXTERNAL}[:CLOCK]",
        required=True,
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
    external = parse_replacements(options.replace, kinds=[EXTERNAL]).external
    node, stamping = parse_clock(external[0] if "=" in external[0] else f"{external[0]}=detect")
    known = [name for name in CONTRACT_OF if name != ADVISER]
    if node not in known or len(external) > 1:
        raise ParameterError(f"{OPTION} {options.replace[-1]}: NODE must be one of {', '.join(known)}")
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
