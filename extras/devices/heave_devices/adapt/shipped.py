"""The device maps that come with the suite."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

from heave_node.files.given_files import shipped_files
from heave_node.parameters import ParameterError

from heave_devices.maps.channel import MapError
from heave_devices.maps.device_map import DeviceMap, read_device_map


def shipped_maps() -> dict[str, Path]:
    """Return the files of the shipped maps by their names."""
    return shipped_files(Path(str(resources.files("heave_devices") / "device_maps")))


def title_of(path: Path) -> str:
    """Return the first comment of the map at `path`: what it is for."""
    first = path.read_text(encoding="utf-8").splitlines()[0]
    return first.lstrip("# ").rstrip()


def find_map(name: str) -> DeviceMap:
    """Return the map that is a file, or the shipped one, called `name`. Raises ParameterError where there is none."""
    path = Path(name) if Path(name).exists() else shipped_maps().get(name, Path(name))
    if not path.exists():
        raise ParameterError(
            f"{name}: there is no such file, and no map is shipped by that name: see heave adapt --list"
        )
    try:
        return read_device_map(path)
    except MapError as error:
        raise ParameterError(str(error)) from None
