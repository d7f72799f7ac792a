"""The control laws that the parameter `law` can name: those of the suite, and those of others.

A law of the suite is a file beside this one, and a line in `LAWS`. A law of somebody else needs no change here:

- an installed package names its class under the entry point `heave.laws`; the law is then selected by its name and
  has its group of parameters as any other,
- `law: my_module:MyLaw` and `law: my_law.py:MyLaw` name a class by its place, an importable module or a file; its
  parameters are in `law_parameters`.

A place is code that will run, so that it is loaded only for a user who named it: `load_law`. Processes that are
started afterwards may load it too (`LOADED`); a name that comes in a message or a bag loads nothing.
"""

from __future__ import annotations

import hashlib
import importlib
import importlib.metadata
import importlib.util
import json
import os
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

from heave_node.parameters import ParameterError, build_parameters

from winch_controller_node.laws.feedforward import SpeedFeedforward
from winch_controller_node.laws.industrial import IndustrialBaseline
from winch_controller_node.laws.law import ControlLaw
from winch_controller_node.laws.lqg import FullStateFeedback
from winch_controller_node.laws.lqr import UnitRegulator
from winch_controller_node.laws.mpc import ConstrainedLaw
from winch_controller_node.laws.off import Off

LAWS: dict[str, type[ControlLaw]] = {
    law.name: law
    for law in (
        Off,
        UnitRegulator,
        FullStateFeedback,
        SpeedFeedforward,
        IndustrialBaseline,
        ConstrainedLaw,
    )
}
"""Laws by name, or by place once they are loaded, in the order in which they are listed."""

ENTRY_POINTS = "heave.laws"
"""Entry points by which an installed package brings laws; each is a class derived from `ControlLaw`."""
PLACE = r"(?:[\w.]+|.+\.py):\w+"
"""What a law may be named by beside its name: MODULE:CLASS, or FILE.py:CLASS."""
LOADED = "HEAVE_LAWS"
"""Environment variable with the places that a process may load without being asked by its user, one a line."""


def law_class(name: str) -> type[ControlLaw]:
    """Return the law of a `name`, or of a place that was loaded by `load_law` here or in the process that began this.

    Raises ParameterError for another.
    """
    if name not in LAWS and name in os.environ.get(LOADED, "").split("\n"):
        load_law(name)
    if name not in LAWS:
        raise ParameterError(f"law {name}: is not loaded in this process; start it with {LOADED}='{name}'")
    return LAWS[name]


def load_law(name: str) -> type[ControlLaw]:
    """Return the law that a user has chosen by its `name` or place; processes started from now on may load it too.

    Raises ParameterError, in one line, where there is no such law.
    """
    if name in LAWS:
        return LAWS[name]
    where, _, wanted = name.rpartition(":")
    module = _file(Path(where), name) if where.endswith(".py") else _module(where, name)
    law = getattr(module, wanted, None)
    if law is None:
        raise ParameterError(f"law {name}: {where} has no {wanted}")
    LAWS[name] = _checked(law, name)
    places = [place for place in os.environ.get(LOADED, "").split("\n") if place]
    os.environ[LOADED] = "\n".join(dict.fromkeys([*places, name]))
    return LAWS[name]


def parameters_of_place(law: type[ControlLaw], given: Sequence[str]) -> Any:
    """Return the parameters of a `law` named by its place, `given` as NAME=VALUE; None for a law that has none.

    Raises ParameterError for what the law does not take.
    """
    values: dict[str, object] = {}
    for one in given:
        name, is_value, text = one.partition("=")
        if not is_value:
            raise ParameterError(f"law_parameters: {one!r} must be NAME=VALUE")
        try:
            values[name.strip()] = json.loads(text)
        except ValueError:
            values[name.strip()] = text
    if law.parameters_type is None:
        if values:
            raise ParameterError(f"law_parameters: law {law.name} has no parameters")
        return None
    return build_parameters(law.parameters_type, values, where=f"law_parameters of law {law.name}")


def _module(where: str, name: str) -> ModuleType:
    """Import a module, also one in the working folder, where a console script does not look."""
    here = str(Path.cwd())
    sys.path.append(here)
    try:
        return importlib.import_module(where)
    except ModuleNotFoundError as error:
        if error.name is not None and (where == error.name or where.startswith(f"{error.name}.")):
            raise ParameterError(f"law {name}: there is no module {where}, installed or in {here}") from error
        raise ParameterError(f"law {name}: {_line(error)}") from error
    except Exception as error:
        raise ParameterError(f"law {name}: {_line(error)}") from error
    finally:
        sys.path.remove(here)


def _file(path: Path, name: str) -> ModuleType:
    """Load a file as a module of its own, which pickle finds again."""
    if not path.is_file():
        raise ParameterError(f"law {name}: no such file: {path}")
    own = f"{path.stem}_{hashlib.sha256(str(path.resolve()).encode()).hexdigest()[:8]}"
    spec = importlib.util.spec_from_file_location(own, path)
    assert spec is not None
    assert spec.loader is not None
    module = sys.modules[own] = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        del sys.modules[own]
        raise ParameterError(f"law {name}: {_line(error)}") from error
    return module


def _checked(law: Any, where: str) -> type[ControlLaw]:
    """Return a `law` if it is one. Raises ParameterError, opened by `where` it comes from, for what is none."""
    if not (isinstance(law, type) and issubclass(law, ControlLaw)):
        raise ParameterError(f"law {where}: is not a class derived from winch_controller_node.laws.law.ControlLaw")
    missing = [name for name in ("name", "summary") if not isinstance(getattr(law, name, None), str)]
    missing += sorted(getattr(law, "__abstractmethods__", ()))
    if missing:
        raise ParameterError(f"law {where}: has no {missing[0]}")
    return law


def _line(error: Exception) -> str:
    return f"{type(error).__name__}: {' '.join(str(error).split())}"


def _installed() -> dict[str, type[ControlLaw]]:
    """Return the laws of installed packages by name.

    One that cannot be loaded is reported on standard error and left out: it must not stop a run under another law.
    """
    found = {}
    for entry in importlib.metadata.entry_points(group=ENTRY_POINTS):
        where = f"{entry.name} of entry point {ENTRY_POINTS} ({entry.value})"
        try:
            law = _checked(entry.load(), where)
            if law.name in LAWS or law.name in found or not re.fullmatch(r"[a-z]\w*", law.name):
                raise ParameterError(f"law {where}: its name, {law.name!r}, is taken or is no word of small letters")
            found[law.name] = law
        except Exception as error:
            sys.stderr.write(f"heave: warning: {error if isinstance(error, ParameterError) else _line(error)}\n")
    return found


LAWS |= _installed()
