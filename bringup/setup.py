"""colcon's view of heave_bringup; name, version, description and licence are in package.xml."""

from pathlib import Path
from xml.etree import ElementTree

from setuptools import find_packages, setup

manifest = ElementTree.parse("package.xml").getroot()
name = manifest.findtext("name")
DATA_SUFFIXES = ("c", "csv", "css", "h", "html", "js", "json", "md", "npz", "txt", "xml", "yaml")


def data_files(folder: str) -> list[tuple[str, list[str]]]:
    """Return what lies in a folder, to be installed under share/PACKAGE."""
    files = sorted(str(path) for path in Path(folder).glob("*") if path.is_file())
    return [(f"share/{name}/{folder}", files)] if files else []


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
        *data_files("launch"),
        *data_files("config"),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
    entry_points={
        "console_scripts": ["heave = heave_bringup.cli:main", "ship_clock = heave_bringup.external.ship_clock:main"],
    },
)
