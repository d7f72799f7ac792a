"""What colcon installs of a Python package: one definition for the setup.py of each.

Name, version, description and licence are in the package's package.xml. A setup.py runs in the folder of its package
and finds this file from there: a package may be linked into another workspace, but not be copied there alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from xml.etree import ElementTree

from setuptools import find_packages, setup

DATA_SUFFIXES = ("c", "csv", "css", "h", "html", "js", "json", "md", "npz", "txt", "xml", "yaml")
"""Endings of the files inside a package that are installed with its modules."""


def set_up(*, scripts: Sequence[str] = (), parts: Mapping[str, Sequence[str]] | None = None) -> None:
    """Set up the package in the working folder.

    Parameters
    ----------
    scripts : its executables, each "NAME = MODULE:FUNCTION"
    parts : what it adds to the suite, each "NAME = PLACE", by the group of entry points, as "heave.commands"
    """
    manifest = ElementTree.parse("package.xml").getroot()
    name = manifest.findtext("name")
    setup(
        name=name,
        version=manifest.findtext("version"),
        description=manifest.findtext("description"),
        license=manifest.findtext("license"),
        maintainer=manifest.findtext("maintainer"),
        maintainer_email=manifest.find("maintainer").get("email"),
        packages=find_packages(include=[name, f"{name}.*"]),
        package_data={name: ["py.typed", *(f"**/*.{suffix}" for suffix in DATA_SUFFIXES)]},
        data_files=[
            ("share/ament_index/resource_index/packages", [f"resource/{name}"]),
            (f"share/{name}", ["package.xml"]),
            *((f"share/{name}/{folder}", files) for folder in ("launch", "config") if (files := files_in(folder))),
        ],
        install_requires=["setuptools"],
        extras_require={"test": ["pytest"]},
        zip_safe=False,
        entry_points={"console_scripts": list(scripts), **{group: list(of) for group, of in (parts or {}).items()}},
    )


def files_in(folder: str) -> list[str]:
    """Return the files that lie in a folder of the package, to be installed under share/PACKAGE."""
    return sorted(str(path) for path in Path(folder).glob("*") if path.is_file())
