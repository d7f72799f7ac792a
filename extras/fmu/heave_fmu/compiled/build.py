"""The controller of a scenario as an FMU without Python: sources, and a library for this system."""

from __future__ import annotations

import hashlib
import json
import os
import platform
import shlex
import subprocess
import tempfile
import zipfile
from importlib.util import find_spec
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import heave_core
from heave_bringup.closed_loop import LoopParameters, loop_parameters
from heave_bringup.errors import CommandError
from heave_bringup.scenarios import Scenario
from heave_core.layout import header
from heave_node.extras import how_to_install
from heave_node.interface import topics
from heave_node.interface.sensors import DEPTH, MRU, SENSORS, Water
from heave_node.numerics.constants import ATMOSPHERIC_PRESSURE
from heave_node.parameters import ParameterError
from winch_controller_node.core.supervision.modes import Mode
from winch_controller_node.interface.conversions import WINCH_STATE as WINCH_MEASURES
from winch_controller_node.interface.sensors import KnownSensors

from heave_fmu.compiled.image import image_header, made_controller, records_of, sizes_of
from heave_fmu.parts import ControllerPart
from heave_fmu.variables import Variable, unit_definitions

MODEL = "heave_controller"
SOURCE = "fmu.c"
FMI_HEADERS = ("fmi2Functions.h", "fmi2FunctionTypes.h", "fmi2TypesPlatform.h")
"""Of the FMI standard, under its own licence (BSD, two clauses), as FMPy brings them."""
LEFT_OUT = (
    "No adviser: nominal values are kept, and a winch, cable, sensor or sea that differs from them is not identified. "
    "No moves, no constant tension: a load that lands stops the winch. No plan at the limits of the winch: "
    "authority is reduced until the peaks of the sea fit"
)
"""What the controller has not without Python, in a line."""
FLAGS = ("-O2", "-ffp-contract=off")
C_FLAGS, CPP_FLAGS = ("-std=c99",), ("-std=c++17", "-fno-exceptions", "-fno-rtti")


def export_controller(scenario: Scenario, folder: Path) -> Path:
    """Write the controller of a `scenario`, compiled, to `controller.fmu` in a `folder`; return its file.

    Raises CommandError, in one line, where the scenario asks for another controller, or nothing can compile it.
    """
    part = ControllerPart(loop_parameters(scenario))
    file = folder / "controller.fmu"
    with tempfile.TemporaryDirectory(prefix="heave-fmu-") as made:
        root = Path(made)
        guid = write_sources(part, root / "sources")
        (root / "modelDescription.xml").write_bytes(_description(part, guid, root / "sources"))
        library = root / "binaries" / "linux64" / f"{MODEL}.so"
        library.parent.mkdir(parents=True)
        if platform.system() != "Linux" or platform.machine() != "x86_64":
            raise CommandError("heave fmu --language c: compiles for Linux on x86-64 only, and this is another system")
        compile_sources(root / "sources", library, "-shared", "-fPIC")
        with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
            for one in sorted(path for path in root.rglob("*") if path.is_file()):
                entry = zipfile.ZipInfo(one.relative_to(root).as_posix())
                entry.compress_type = zipfile.ZIP_DEFLATED
                archive.writestr(entry, one.read_bytes())
    return file


def controller_sources(parameters: LoopParameters) -> dict[str, str]:
    """Return the sources of the controller of a loop with these `parameters`, by file: the core's, and an image.

    Raises CommandError, in one line, for a controller that cannot go on without Python.
    """
    try:
        core = made_controller(parameters)
    except ParameterError as error:
        raise CommandError(f"heave fmu --language c: {error}") from error
    records, own = records_of(core), Path(heave_core.__file__).parent
    paths = [
        path for path in sorted((*(own / "src").iterdir(), *(own / "plc").iterdir())) if path.suffix in (".h", ".cpp")
    ]
    texts = {path.name: path.read_text() for path in paths if path.name != "interface.cpp"}
    return texts | {"layout.h": header(**sizes_of(core, records)), "image.h": image_header(records)}


def write_sources(part: ControllerPart, folder: Path) -> str:
    """Write all that the controller `part` is compiled of into a new `folder`; return the GUID: their hash."""
    fmpy = find_spec("fmpy")
    if fmpy is None or fmpy.origin is None:
        raise CommandError(f"heave fmu --language c: needs the package fmpy; {how_to_install('fmu')}")
    texts = controller_sources(part.parameters) | {SOURCE: (Path(__file__).parent / SOURCE).read_text()}
    texts |= {name: (Path(fmpy.origin).parent / "c-code" / name).read_text() for name in FMI_HEADERS}
    guid = hashlib.sha256("\n".join([*texts.values(), interface_header(part, "")]).encode()).hexdigest()
    texts["interface.h"] = interface_header(part, guid)
    folder.mkdir()
    for name, text in texts.items():
        (folder / name).write_text(text)
    return guid


def interface_header(part: ControllerPart, guid: str) -> str:
    """Return `interface.h`: times, ports and variables of the controller `part` by their references, and its `guid`."""
    variables, inputs = _variables(part)
    names = [variable.name.replace(".", "_").replace("[", "_").replace("]", "") for variable in variables]
    lines = [
        f"#define TICK_PERIOD {part.tick_period!r}",
        f"#define TICK_NANOSECONDS {round(part.tick_period * 1e9)}.0",
        f"#define INSTANT {part.instant!r}",
        f"#define VARIABLES {len(variables)}",
        f"#define FIRST_OUTPUT {inputs}",
        f'#define GUID "{guid}"',
        f'#define KINDS "{"".join(variable.kind[0] for variable in variables)}"',
        f"#define INPUT_PORTS {{{', '.join(_ports(part))}}}",
        f"#define MODE_NAMES {{{', '.join(json.dumps(mode.value) for mode in Mode)}}}",
        f"enum {{ {', '.join(f'MRU_{name.upper()}' for name in MRU.values)} }};",
        f"enum {{ {', '.join(f'WINCH_{name.upper()}' for name in WINCH_MEASURES)} }};",
        f"enum {{ {', '.join(names)} }};",
    ]
    return "\n".join(["#ifndef HEAVE_INTERFACE_H", "#define HEAVE_INTERFACE_H", *lines, "#endif", ""])


def _ports(part: ControllerPart) -> list[str]:
    """Return the messages in, of the sensors that the controller knows, as C initialises them: the MRU's first."""
    references, count = dict[str, int](), 0
    for name, port in part.inputs.items():
        references[name], count = count, count + len(port.variables)
    water = Water(part.parameters.controller.water_density, part.parameters.controller.gravity)
    found = []
    for index, (name, known) in enumerate(KnownSensors().by_name().items()):
        topic = topics.WINCH_STATE if name == "encoder" else SENSORS[name].topic
        if topic.name not in part.inputs:
            continue
        slots, width = part.inputs[topic.name].sizes
        zero, scale = (ATMOSPHERIC_PRESSURE, water.pressure_per_metre) if name == DEPTH.name else (0.0, 1.0)
        zero = water.gravity if known.includes_gravity else zero
        numbers = references[topic.name], slots, width, index, known.component, repr(zero), repr(scale)
        found.append(f"{{{', '.join(map(str, numbers))}}}")
    return found


def compile_sources(folder: Path, target: Path, *flags: str) -> None:
    """Compile the sources in a `folder` to the `target` by the compilers in CC and CXX, or gcc and g++.

    `flags` are added to FLAGS. Raises CommandError, in one line, where that fails.
    """
    by_ending = {".c": ("CC", "gcc", C_FLAGS), ".cpp": ("CXX", "g++", CPP_FLAGS)}
    with tempfile.TemporaryDirectory(prefix="heave-fmu-") as made:
        objects = []
        for path in sorted(path for path in folder.iterdir() if path.suffix in by_ending):
            variable, usual, own = by_ending[path.suffix]
            objects.append(str(Path(made) / f"{path.stem}{path.suffix[1:]}.o"))
            _compile(variable, usual, *own, *FLAGS, *flags, "-c", str(path), "-o", objects[-1])
        _compile("CC", "gcc", *FLAGS, *flags, *objects, "-o", str(target), "-lm")


def _compile(variable: str, usual: str, *words: str) -> None:
    """Run the compiler that an environment `variable` names, or the `usual` one, with these `words`."""
    compiler = shlex.split(os.environ.get(variable) or usual)
    try:
        subprocess.run([*compiler, *words], check=True, capture_output=True, text=True)
    except OSError as error:
        kind = "C" if variable == "CC" else "C++"
        raise CommandError(
            f"heave fmu --language c: {compiler[0]}: {error.strerror}; {variable} names a {kind} compiler"
        ) from error
    except subprocess.CalledProcessError as error:
        raise CommandError(f"heave fmu --language c: {compiler[0]}: {' '.join(error.stderr.split())[:300]}") from error


def _variables(part: ControllerPart) -> tuple[list[Variable], int]:
    """Return the variables of a `part`, inputs first, and the number of these; the place is the reference."""
    inputs = [variable for port in part.inputs.values() for variable in port.variables]
    return inputs + [variable for port in part.outputs.values() for variable in port.variables], len(inputs)


def _description(part: ControllerPart, guid: str, sources: Path) -> bytes:
    """Return the model description of a `part` with its `guid`, whose `sources` are in that folder."""
    variables, inputs = _variables(part)
    starts = [value for port in part.inputs.values() for value in port.values]
    what = f"controller of an active heave compensation, law {part.parameters.controller.law}. {LEFT_OUT}"
    root = Element("fmiModelDescription", fmiVersion="2.0", modelName=MODEL, guid=guid, description=what)
    simulation = SubElement(root, "CoSimulation", modelIdentifier=MODEL, canHandleVariableCommunicationStepSize="true")
    files = SubElement(simulation, "SourceFiles")
    for path in sorted(path for path in sources.iterdir() if path.suffix in (".c", ".cpp")):
        SubElement(files, "File", name=path.name)
    root.append(unit_definitions(variable.unit for variable in variables))
    SubElement(root, "DefaultExperiment", startTime="0", stepSize=repr(part.tick_period))
    listed = SubElement(root, "ModelVariables")
    for index, variable in enumerate(variables):
        causality = {"causality": "input"} if index < inputs else {"causality": "output", "initial": "calculated"}
        names = {"name": variable.name, "valueReference": str(index), "description": variable.meaning}
        element = SubElement(listed, "ScalarVariable", names | causality, variability="discrete")
        start = {"start": str(starts[index]).lower()} if index < inputs else {}
        SubElement(element, variable.kind, start | ({"unit": variable.unit} if variable.unit else {}))
    structure = SubElement(root, "ModelStructure")
    for name in ("Outputs", "InitialUnknowns"):
        unknowns = SubElement(structure, name)
        for index in range(inputs, len(variables)):
            SubElement(unknowns, "Unknown", index=str(index + 1))
    indent(root)
    return bytes(tostring(root, encoding="UTF-8", xml_declaration=True)) + b"\n"
