"""`heave --version`."""

from __future__ import annotations

import argparse
import sys
from importlib import metadata
from typing import NoReturn

DISTRIBUTIONS = ("heave", "heave-bringup")
"""Under which this project is installed: as a whole from wheels, or package by package by colcon."""


class VersionAction(argparse.Action):
    """Prints the version and, where it is known, the git commit; both are looked for only then.

    Parameters
    ----------
    option_strings, dest : as argparse gives them
    """

    def __init__(self, option_strings: list[str], dest: str) -> None:
        super().__init__(option_strings, dest, nargs=0, help="print the version, and the git commit where it is known")

    def __call__(self, *_: object) -> NoReturn:
        """Print, and end."""
        from heave_bags.record.provenance import git_commit

        commit = git_commit()
        sys.stdout.write(f"heave {own_version()}{f' ({commit})' if commit else ''}\n")
        sys.exit(0)


def own_version() -> str:
    """Return the version of this project; "of unknown version" where it is not installed."""
    found = (one.version for name in DISTRIBUTIONS for one in metadata.distributions(name=name))
    return next(found, "of unknown version")
