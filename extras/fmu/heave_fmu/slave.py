"""A part of the loop as a slave of PythonFMU."""

from __future__ import annotations

import hashlib
import math
import sys
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, SubElement

from heave_bringup.closed_loop import loop_parameters
from heave_bringup.scenarios import load_scenario
from heave_node.errors import one_line
from pythonfmu import (
    Boolean,
    DefaultExperiment,
    Fmi2Causality,
    Fmi2Initial,
    Fmi2Slave,
    Fmi2Variability,
    Integer,
    Real,
    String,
)
from pythonfmu.enums import Fmi2Status

from heave_fmu.parts import PARTS
from heave_fmu.ports import Port
from heave_fmu.variables import BOOLEAN, INTEGER, REAL, STRING, unit_definitions

SCENARIO = "scenario.yaml"
"""The scenario among the resources of an FMU."""

_KEPT: list[object] = []
"""The module of each instance, and references to its names.

PythonFMU 0.7.0 gives one up that it does not own when it makes and when it ends an instance. Where the host is Python
itself, the next collection of garbage would then read freed memory.
"""

_TYPES = {REAL: Real, INTEGER: Integer, BOOLEAN: Boolean, STRING: String}


class PartSlave(Fmi2Slave):  # type: ignore[misc]  # without types
    """A part, stepped as an FMU.

    `part` is its name, of `parts.PARTS`; `kwargs` are those of PythonFMU: `resources` is the folder with the scenario.
    """

    part = ""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        module = sys.modules[type(self).__module__]
        _KEPT.extend((module, vars(module), vars(module)))
        file = Path(self.resources) / SCENARIO
        parameters = loop_parameters(load_scenario(str(file)))
        self._part = PARTS[self.part](parameters)
        self._done = 0
        self.guid = hashlib.sha256(f"{self.part}\n{file.read_text()}".encode()).hexdigest()
        self.description = f"{self.part} of an active heave compensation, by its scenario"
        dt = parameters.tick_period
        self.default_experiment = DefaultExperiment(start_time=0.0, stop_time=parameters.duration, step_size=dt)
        for port in self._part.inputs.values():
            self._register(port, Fmi2Causality.input)
        for port in self._part.outputs.values():
            self._register(port, Fmi2Causality.output)

    def _register(self, port: Port, causality: Fmi2Causality) -> None:
        values = port.values
        initial = Fmi2Initial.calculated if causality is Fmi2Causality.output else None
        for index, variable in enumerate(port.variables):
            self.register_variable(
                _TYPES[variable.kind](
                    variable.name,
                    causality=causality,
                    variability=Fmi2Variability.discrete,
                    initial=initial,
                    description=variable.meaning,
                    getter=lambda index=index: values[index],
                    setter=lambda value, index=index: values.__setitem__(index, value),
                ),
                nested=False,
            )

    def to_xml(self, *arguments: Any, **options: Any) -> Element:
        """Return the model description of PythonFMU with units, and with outputs that are known from the start on.

        `arguments` and `options` are those of PythonFMU. The time of export is left out: equal contents are equal.
        """
        root: Element = super().to_xml(*arguments, **options)
        del root.attrib["generationDateAndTime"]
        ports = (*self._part.inputs.values(), *self._part.outputs.values())
        units = [variable.unit for port in ports for variable in port.variables]
        root.insert(1, unit_definitions(units))
        for element, unit_name in zip(root.iter("ScalarVariable"), units, strict=True):
            if unit_name:
                element[0].set("unit", unit_name)
        outputs = root.find("ModelStructure/Outputs")
        unknowns = [] if outputs is None else [dict(unknown.attrib) for unknown in outputs]
        initial = SubElement(root.find("ModelStructure"), "InitialUnknowns")  # type: ignore[arg-type]
        for attributes in unknowns:
            SubElement(initial, "Unknown", attributes)
        return root

    def enter_initialization_mode(self) -> None:
        """Begin the part, also after a reset: its outputs are those of the first tick."""
        self._done = 0
        for port in (*self._part.inputs.values(), *self._part.outputs.values()):
            port.restart()
        self._part.start()

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Do the part's work of each tick whose instant lies before the end of the step; False where it cannot go on.

        `current_time` and `step_size` are in [s], time 0 is the first tick.
        """
        end = (current_time + step_size) / self._part.tick_period
        try:
            while self._done < math.ceil(end - self._part.instant):
                self._done += 1
                for alarm in self._part.step(self._done):
                    self.log(alarm, Fmi2Status.warning)
        except Exception as error:
            self.log(f"{self.part}: {one_line(error)}", Fmi2Status.error)
            return False
        return True
