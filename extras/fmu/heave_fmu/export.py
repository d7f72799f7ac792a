"""Parts of a scenario's loop as FMU files, and the system that wires them for libcosim."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from heave_bringup.closed_loop import loop_parameters
from heave_bringup.scenarios import Scenario
from heave_bringup.stored_scenario import stored_sections, stored_title
from heave_node.parameters import ParameterError
from heave_node.scenario import sections_text

from heave_fmu.compiled.build import export_controller
from heave_fmu.part import STEPS, Part
from heave_fmu.parts import PARTS
from heave_fmu.slave import SCENARIO

SYSTEM = "OspSystemStructure.xml"
"""File that libcosim reads a system from."""

_NAMESPACE = "http://opensimulationplatform.com/MSMI/OSPSystemStructure"

_SCRIPT = '''"""The {part} of a scenario; needs the Python environment of heave."""

from heave_fmu.slave import PartSlave


class Heave{name}(PartSlave):
    """Stepped as an FMU."""

    part = "{part}"
'''


def export_part(scenario: Scenario, part: str, folder: Path, language: str = "python") -> Path:
    """Write a part of the loop as an FMU, `PART.fmu`, and return its file.

    Parameters
    ----------
    scenario : its active values go into the FMU
    part : a name of `parts.PARTS`
    folder : where the file goes
    language : of the controller: "python", or "c" for the compiled one, which needs no Python and has no adviser
    """
    if part == "controller" and language == "c":
        return export_controller(scenario, folder)
    from pythonfmu.builder import FmuBuilder  # noqa: PLC0415 - an extra

    file = folder / f"{part}.fmu"
    with tempfile.TemporaryDirectory(prefix="heave-fmu-") as made:
        script = Path(made) / f"heave_{part}.py"
        script.write_text(_SCRIPT.format(part=part, name=part.capitalize()))
        stored = Path(made) / SCENARIO
        stored.write_text(sections_text(stored_sections(scenario), title=stored_title(scenario)))
        # PythonFMU cannot read the script of an instance twice where the host is Python
        once = {"canBeInstantiatedOnlyOncePerProcess": "true"}
        FmuBuilder.build_FMU(script, dest=file, project_files=[stored], **once)
    return file


def connections(parts: Mapping[str, Part]) -> list[tuple[str, str, str]]:
    """Return which variable goes from which of the `parts` to which: (name, from, to).

    An input takes the output of the same name: both are named by topic and field.
    """
    sources = {
        variable.name: name
        for name, part in parts.items()
        for port in part.outputs.values()
        for variable in port.variables
    }
    return [
        (variable.name, sources[variable.name], name)
        for name, part in parts.items()
        for port in part.inputs.values()
        for variable in port.variables
        if variable.name in sources
    ]


def make_parts(scenario: Scenario, names: Iterable[str] = PARTS) -> dict[str, Part]:
    """Return parts of the loop of a `scenario` by their `names`, not begun.

    Raises ParameterError for what has no variables: a crane that moves, a preview of the sea.
    """
    parameters = loop_parameters(scenario)
    sea = parameters.sea
    if sea.crane.is_fitted or sea.preview.time > 0.0:
        raise ParameterError(
            "heave fmu: a crane that moves and a preview of the sea have no variables: "
            "--set system.crane.fitted=false or wave_vessel.preview.time=0"
        )
    return {name: PARTS[name](parameters) for name in names}


def write_system(scenario: Scenario, folder: Path) -> Path:
    """Write the system of all parts of a `scenario`, whose FMUs are in a `folder`, for libcosim; return its file."""
    parts = make_parts(scenario)
    step = f"{scenario.run.tick_period / STEPS:.12g}"
    root = Element("OspSystemStructure", xmlns=_NAMESPACE, version="0.1")
    SubElement(root, "BaseStepSize").text = step
    SubElement(root, "Algorithm").text = "fixedStep"
    simulators = SubElement(root, "Simulators")
    for name in parts:
        SubElement(simulators, "Simulator", name=name, source=f"{name}.fmu", stepSize=step)
    wires = SubElement(root, "Connections")
    for variable, source, target in connections(parts):
        wire = SubElement(wires, "VariableConnection")
        SubElement(wire, "Variable", simulator=source, name=variable)
        SubElement(wire, "Variable", simulator=target, name=variable)
    indent(root)
    file = folder / SYSTEM
    file.write_bytes(tostring(root, encoding="UTF-8", xml_declaration=True) + b"\n")
    return file
