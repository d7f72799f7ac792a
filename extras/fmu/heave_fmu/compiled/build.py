"""The fixed controller of a scenario as an FMU of C: sources, and a library for this system."""

from __future__ import annotations

import hashlib
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
from heave_bringup.closed_loop import loop_parameters
from heave_bringup.errors import CommandError
from heave_bringup.scenarios import Scenario
from heave_core.layout import header
from heave_node.extras import how_to_install

from heave_fmu.compiled.part import LEFT_OUT, FixedControllerPart
from heave_fmu.compiled.tables import bounds_header, design_header, interface_header
from heave_fmu.variables import Variable, unit_definitions

MODEL = "heave_controller"
SOURCES = ("filter.c", "controller.c", "fmu.c", "last_step.cpp")
HEADERS = ("filter.h", "controller.h", "last_step.h")
CORE = ("drum.cpp", "envelope.cpp", "move.cpp", "ship.cpp", "parts.h")
"""The envelope's own sources, of heave_core."""
FMI_HEADERS = ("fmi2Functions.h", "fmi2FunctionTypes.h", "fmi2TypesPlatform.h")
"""Of the FMI standard, under its own licence (BSD, two clauses), as FMPy brings them."""
FLAGS = ("-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror")
C_FLAGS, CPP_FLAGS = ("-std=c99",), ("-std=c++17", "-fno-exceptions", "-fno-rtti")

_OWN = Path(__file__).parent


def export_controller(scenario: Scenario, folder: Path) -> Path:
    """Write the fixed controller of a `scenario` to `controller.fmu` in a `folder`; return its file.

    Raises CommandError, in one line, where the scenario asks for another controller, or nothing can compile it.
    """
    part = FixedControllerPart(loop_parameters(scenario))
    file = folder / "controller.fmu"
    with tempfile.TemporaryDirectory(prefix="heave-fmu-") as made:
        root = Path(made)
        guid = write_sources(part, root / "sources")
        (root / "modelDescription.xml").write_bytes(_description(part, guid))
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


def write_sources(part: FixedControllerPart, folder: Path) -> str:
    """Write all that the controller `part` is compiled of into a new `folder`; return the GUID: their hash."""
    fmpy = find_spec("fmpy")
    if fmpy is None or fmpy.origin is None:
        raise CommandError(f"heave fmu --language c: needs the package fmpy; {how_to_install('fmu')}")
    variables, inputs = _variables(part)
    texts = {name: (_OWN / name).read_text() for name in (*SOURCES, *HEADERS)}
    texts |= {name: (Path(fmpy.origin).parent / "c-code" / name).read_text() for name in FMI_HEADERS}
    texts |= {name: (core_sources() / name).read_text() for name in CORE}
    texts |= {"layout.h": header(), "bounds.h": bounds_header(part)}
    texts["design.h"] = "#include <math.h>\n" + design_header(part)
    guid = hashlib.sha256("\n".join([*texts.values(), interface_header(part, variables, inputs, "")]).encode())
    texts["interface.h"] = interface_header(part, variables, inputs, guid.hexdigest())
    folder.mkdir()
    for name, text in texts.items():
        (folder / name).write_text(text)
    return guid.hexdigest()


def core_sources() -> Path:
    """Return the folder of the sources of heave_core."""
    return Path(heave_core.__file__).parent / "src"


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


def _variables(part: FixedControllerPart) -> tuple[list[Variable], int]:
    """Return the variables of a `part`, inputs first, and the number of these; the place is the reference."""
    inputs = [variable for port in part.inputs.values() for variable in port.variables]
    return inputs + [variable for port in part.outputs.values() for variable in port.variables], len(inputs)


def _description(part: FixedControllerPart, guid: str) -> bytes:
    """Return the model description of a `part`."""
    variables, inputs = _variables(part)
    starts = [value for port in part.inputs.values() for value in port.values]
    what = f"controller of an active heave compensation, law {part.design.parameters.law}. {LEFT_OUT}"
    root = Element("fmiModelDescription", fmiVersion="2.0", modelName=MODEL, guid=guid, description=what)
    simulation = SubElement(root, "CoSimulation", modelIdentifier=MODEL, canHandleVariableCommunicationStepSize="true")
    files = SubElement(simulation, "SourceFiles")
    for name in (*SOURCES, *(one for one in CORE if one.endswith(".cpp"))):
        SubElement(files, "File", name=name)
    root.append(unit_definitions(variable.unit for variable in variables))
    SubElement(root, "DefaultExperiment", startTime="0", stepSize=repr(part.tick_period))
    listed = SubElement(root, "ModelVariables")
    for index, variable in enumerate(variables):
        causality = {"causality": "input"} if index < inputs else {"causality": "output", "initial": "calculated"}
        names = {"name": variable.name, "valueReference": str(index), "description": variable.meaning}
        element = SubElement(listed, "ScalarVariable", names | causality, variability="discrete")
        start = {"start": str(starts[index])} if index < inputs else {}
        SubElement(element, variable.kind, start | ({"unit": variable.unit} if variable.unit else {}))
    structure = SubElement(root, "ModelStructure")
    for name in ("Outputs", "InitialUnknowns"):
        unknowns = SubElement(structure, name)
        for index in range(inputs, len(variables)):
            SubElement(unknowns, "Unknown", index=str(index + 1))
    indent(root)
    return bytes(tostring(root, encoding="UTF-8", xml_declaration=True)) + b"\n"
