"""Entrants by name, and anyone's own: FILE:Class or module:Class."""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

from heave_node.parameters import ParameterError

from heave_bringup.benchmark.entrants.industrial import Industrial
from heave_bringup.benchmark.entrants.locked import Locked
from heave_bringup.benchmark.entrants.published_laws import Mas410Law, ZinageInversion, ZinageLqi, ZinagePid
from heave_bringup.benchmark.entrants.suite_laws import suite_law
from heave_bringup.benchmark.interface import Entrant

SHIPPED: dict[str, tuple[Entrant, str]] = {
    "locked": (Locked, "the winch follows the target only"),
    "industrial": (Industrial, "feed-forward and outlet position loop, tuned by rule"),
    "suite:lqg": (suite_law("lqg"), "this suite's LQG law"),
    "suite:mpc": (suite_law("mpc"), "this suite's constrained law"),
    "suite:industrial": (suite_law("industrial"), "the same baseline on this suite's estimator"),
    "suite:feedforward": (suite_law("feedforward"), "this suite's speed feed-forward"),
    "published:pid": (ZinagePid, "PID of Zinage & Somayajula"),
    "published:lqi": (ZinageLqi, "LQI of Zinage & Somayajula"),
    "published:inversion": (ZinageInversion, "inversion that knows the future: a reference, not an entry"),
    "published:mas410": (Mas410Law, "outer loop of a published solution of MAS410"),
}


@dataclass(frozen=True)
class Named:
    """An entrant by the name the user gave it; it can be sent to another process, and made there."""

    name: str

    @property
    def short_name(self) -> str:
        """The name without the folder of the file: it is the same on another machine."""
        where, separator, attribute = self.name.rpartition(":")
        return f"{Path(where).name}:{attribute}" if separator and where.endswith(".py") else self.name

    def load(self) -> Entrant:
        """Return the entrant; raises ParameterError where there is none of that name."""
        if self.name in SHIPPED:
            return SHIPPED[self.name][0]
        where, _, attribute = self.name.rpartition(":")
        if not where or not attribute.isidentifier():
            raise ParameterError(
                f"{self.name}: no such entrant; give FILE:Class or module:Class, or one of {', '.join(SHIPPED)}"
            )
        made: Any = getattr(_module(where), attribute, None)
        if not callable(made):
            raise ParameterError(f"{self.name}: {where} has no class {attribute}")
        entrant: Callable[..., Any] = made
        return entrant


def _module(where: str) -> ModuleType:
    """Return a module by its name or its file; raises ParameterError, in one line, for one that cannot be loaded."""
    path = Path(where)
    try:
        if path.suffix != ".py":
            return importlib.import_module(where)
        if not path.is_file():
            raise ParameterError(f"{where}: no such file")
        spec = importlib.util.spec_from_file_location(f"entrant_{path.stem}", path)
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    except ParameterError:
        raise
    except (
        Exception
    ) as error:  # whatever an entrant's file does on loading is the entrant's fault, reported in one line
        raise ParameterError(f"{where}: cannot be loaded: {type(error).__name__}: {error}") from error
    return module
