"""Registries: what a parameter may name, one line each, loaded on first use.

A registry is a dict of entries by name. The parameter's choices, its help and whoever builds the thing named all read
it, so that one more spectrum, say, is its own file and one line. Reading a registry loads nothing: parameters can be
checked without the models that they name.
"""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Entry:
    """One line of a registry."""

    location: str  # "module:name" of what builds the thing
    description: str  # a phrase for the help of the parameter

    def load(self) -> Any:
        """Return what is at the location. Raises ImportError or AttributeError where nothing does."""
        module, name = self.location.split(":")
        return getattr(importlib.import_module(module), name)


def describe_choices(registry: Mapping[str, Entry]) -> str:
    """Return names and descriptions of a `registry` as one phrase: `regular (a sine), file (a recording)`."""
    return ", ".join(f"{name} ({entry.description})" for name, entry in registry.items())
