"""An FMU for co-simulation (FMI 2.0), loaded by FMPy: variables by name, steps. Its code runs in this process."""

from __future__ import annotations

import math
import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from heave_bringup.errors import CommandError

from heave_fmu.archive import described, unpack_fmu

_STEP_ROUNDING = 1e-6
"""Share of a tick by which an FMU's own steps may miss it: both are printed decimals."""


class FmuInstance:
    """An FMU in use.

    Parameters
    ----------
    file : the FMU
    name : of the instance, for the FMU's messages
    start : values of parameters and inputs by name, set before it begins

    Attributes
    ----------
    kinds : type of each variable (Real, Integer, Boolean, String) by its name

    Raises CommandError, in one line, where it cannot be used. `close` frees it.
    """

    def __init__(self, file: Path, name: str, start: Mapping[str, Any] | None = None) -> None:
        from fmpy.fmi2 import FMU2Slave  # noqa: PLC0415 - an extra

        self.file = file
        self._start = dict(start or {})
        self._folder = Path(tempfile.mkdtemp(prefix="heave-fmu-"))
        self._slave: Any = None
        try:
            unpack_fmu(file, self._folder)
            description = described(file, self._folder)
            self.kinds: dict[str, str] = {one.name: one.type for one in description.modelVariables}
            self._step = _fixed_step(description)
            self._references = {one.name: one.valueReference for one in description.modelVariables}
            self._slave = self._asked(
                FMU2Slave,
                guid=description.guid,
                modelIdentifier=description.coSimulation.modelIdentifier,
                unzipDirectory=str(self._folder),
                instanceName=name,
            )
            self._asked(self._slave.instantiate)
            self._begin()
        except BaseException:
            shutil.rmtree(self._folder, ignore_errors=True)
            raise

    def _begin(self) -> None:
        for variable, value in self._start.items():
            self.set(variable, value)
        self._asked(self._slave.setupExperiment, startTime=0.0)
        self._asked(self._slave.enterInitializationMode)
        self._asked(self._slave.exitInitializationMode)

    def restart(self) -> None:
        """Begin again at time 0. Raises CommandError where the FMU cannot."""
        self._asked(self._slave.terminate)
        self._asked(self._slave.reset)
        self._begin()

    def set(self, variable: str, value: Any) -> None:
        """Set a `variable` to a `value`. Raises CommandError where it is not there, or takes no such value."""
        kind = self._kind(variable)
        self._asked(getattr(self._slave, f"set{kind}"), [self._references[variable]], [value], of=f"{variable}: ")

    def get(self, variable: str) -> Any:
        """Return the value of a `variable`. Raises CommandError where it is not there."""
        kind = self._kind(variable)
        (value,) = self._asked(getattr(self._slave, f"get{kind}"), [self._references[variable]])
        return value.decode(errors="replace") if isinstance(value, bytes) else value

    def steps_in(self, duration: float) -> int:
        """Return the number of the FMU's steps in a `duration` [s]; one where it takes any.

        Raises CommandError where its own step is fixed and is no fraction of that.
        """
        if math.isnan(self._step):
            return 1
        steps = max(round(duration / self._step), 1)
        if abs(steps * self._step - duration) > _STEP_ROUNDING * duration:
            raise CommandError(
                f"{self.file}: takes steps of {self._step:g} s alone, and a tick is {duration:g} s: "
                "--set all.tick_period to a multiple of its step"
            )
        return steps

    def step(self, time: float, duration: float) -> None:
        """Step from a `time` on for a `duration` [s], by its own step where that is fixed.

        Raises CommandError where the FMU cannot go on.
        """
        steps = self.steps_in(duration)
        for number in range(steps):
            self._asked(self._slave.doStep, time + number * duration / steps, duration / steps)

    def close(self) -> None:
        """End and free the FMU."""
        try:
            self._asked(self._slave.terminate)
            self._slave.freeInstance()
        finally:
            shutil.rmtree(self._folder, ignore_errors=True)

    def _kind(self, variable: str) -> str:
        kind = self.kinds.get(variable)
        if kind is None:
            raise CommandError(f"{self.file}: it has no variable {variable}")
        return "Integer" if kind == "Enumeration" else kind

    def _asked(self, call: Any, *arguments: Any, of: str = "", **options: Any) -> Any:
        """Return what a `call` of FMPy gives; what goes wrong in the FMU, or `of` a variable, is one line."""
        try:
            return call(*arguments, **options)
        except Exception as error:  # whatever somebody else's file brings about
            raise CommandError(f"{self.file}: {of}{' '.join(str(error).split()) or type(error).__name__}") from error


def _fixed_step(description: Any) -> float:
    """Return the step that an FMU of this `description` by FMPy takes alone [s]; NaN: it takes any, or states none."""
    experiment = description.defaultExperiment
    takes_any = description.coSimulation.canHandleVariableCommunicationStepSize
    stated = None if experiment is None else experiment.stepSize
    if stated is None or takes_any is True or takes_any == "true":
        return math.nan
    step = float(stated)
    return step if math.isfinite(step) and step > 0.0 else math.nan
