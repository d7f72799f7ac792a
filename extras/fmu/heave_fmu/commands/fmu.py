"""`heave fmu`: parts of a scenario's loop as FMUs for co-simulation."""

from __future__ import annotations

import argparse
from importlib.util import find_spec
from pathlib import Path

from heave_bringup.commands.arguments import add_scenario
from heave_bringup.errors import CommandError
from heave_node.extras import how_to_install
from heave_node.parameters import ParameterError

SUMMARY = "Export vessel, plant, winch and controller of a scenario as FMUs for co-simulation (FMI 2.0)."
EXAMPLES = (
    "heave fmu b2_calm_300",
    "heave fmu b3_deep_900 --part plant --part winch --folder fmus",
    "heave fmu b2_calm_300 --part controller --language c --set winch_controller.law=lqg",
)

PARTS = ("vessel", "plant", "winch", "controller")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    add_scenario(parser)
    parser.add_argument(
        "--part",
        action="append",
        choices=PARTS,
        metavar="PART",
        help=f"export only this part: {', '.join(PARTS)} (default: all, wired for libcosim)",
    )
    parser.add_argument(
        "--language",
        choices=("python", "c"),
        default="python",
        help="c: compiled controller with its sources, without adviser, for targets without Python (default: python)",
    )
    parser.add_argument("--folder", type=Path, metavar="DIR", help="output folder (default: SCENARIO_fmu)")


def execute(options: argparse.Namespace) -> None:
    """Write the FMUs that `options` name, and say what they have."""
    chosen = list(dict.fromkeys(options.part or PARTS))
    if options.language == "c" and "controller" not in chosen:
        raise ParameterError("--language c: only the controller can be in C: --part controller")
    if find_spec("pythonfmu") is None:
        raise CommandError(f"heave fmu: needs the package pythonfmu; {how_to_install('fmu')}")
    from heave_bringup.output import write_result
    from heave_bringup.scenarios import load_scenario

    from heave_fmu.export import export_part, make_parts, write_system

    scenario = load_scenario(options.scenario, settings=options.set)
    folder: Path = options.folder or Path(f"{scenario.name}_fmu")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ParameterError(f"--folder {folder}: {error.strerror}") from error
    lines, files = [], {}
    for name, part in make_parts(scenario, chosen).items():
        file = export_part(scenario, name, folder, options.language).resolve()
        ins, outs = (sum(len(port.variables) for port in ports.values()) for ports in (part.inputs, part.outputs))
        lines.append(f"{file}: {ins} variables in, {outs} out, step {scenario.run.tick_period:g} s or a quarter of it")
        files[name] = {"file": str(file), "inputs": ins, "outputs": outs}
    system = None if options.part else write_system(scenario, folder).resolve()
    lines += [] if system is None else [f"{system}: all of them, wired for libcosim"]
    write_result(options, "\n".join(lines), {"parts": files, "system": system and str(system)})
