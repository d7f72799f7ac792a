"""Where in whose code an error arose: one line for a user, and for whoever wrote a node of their own."""

from __future__ import annotations

import inspect
import sysconfig
import traceback
from pathlib import Path
from types import FrameType

SUITE = frozenset(
    (
        *("heave_core", "heave_node", "wave_vessel_node", "cable_sim_node", "winch_controller_node"),
        *("heave_bags", "heave_bringup", "heave_devices", "heave_studies", "heave_statics"),
        *("heave_drives", "heave_panel", "heave_fmu"),
    )
)
"""Packages whose ValueError, and every exception of their own, is worded for the user."""

LIBRARIES = frozenset(Path(sysconfig.get_path(kind)).resolve() for kind in ("stdlib", "purelib", "platlib"))
"""Folders of Python and of what is installed."""


class NodeError(Exception):
    """A node that cannot go on; the message is one line for the user."""


def one_line(error: BaseException, of: type | None = None) -> str:
    """Return `error` as one line: its text alone where it was expected; else with its type and its place.

    Parameters
    ----------
    error : that ended a node
    of : class of the node; the place is the innermost line of the user's own code, such as a law from a file, else in
        the folder of the node's file, else of all
    """
    text = " ".join(str(error).split())
    if text and _is_foreseen(error):
        return text
    named = f"{type(error).__name__}: {text}" if text else type(error).__name__
    place = _place(error, of)
    return f"{named} ({place})" if place else named


def _frames(error: BaseException) -> list[tuple[FrameType, int]]:
    return list(traceback.walk_tb(error.__traceback__))


def _is_foreseen(error: BaseException) -> bool:
    """Return whether whoever raised an error worded it for the user."""
    if type(error).__module__.partition(".")[0] in SUITE:
        return True
    frames = _frames(error)
    raised_in = str(frames[-1][0].f_globals.get("__package__") or "") if frames else ""
    return isinstance(error, ValueError) and (not frames or raised_in.partition(".")[0] in SUITE)


def _place(error: BaseException, of: type | None) -> str:
    """Return file and line of an error; "" where Python does not know."""
    if isinstance(error, SyntaxError) and error.filename:
        return f"{Path(error.filename).name}, line {error.lineno}"
    frames = _frames(error)
    places = [(Path(frame.f_code.co_filename), line) for frame, line in frames]
    of_user = [place for place, (frame, _) in zip(places, frames, strict=True) if _is_of_user(frame)]
    home = _folder_of(of)
    own = [place for place in places if home is not None and home in place[0].resolve().parents]
    for path, line in reversed(of_user or own or places):
        return f"{path.name}, line {line}"
    return ""


def _is_of_user(frame: FrameType) -> bool:
    """Return whether the code of a frame is neither the suite's nor a library's."""
    package = str(frame.f_globals.get("__package__") or "").partition(".")[0]
    file = Path(frame.f_code.co_filename)
    return package not in SUITE and file.suffix == ".py" and not LIBRARIES & {*file.resolve().parents}


def _folder_of(kind: type | None) -> Path | None:
    try:
        return None if kind is None else Path(inspect.getfile(kind)).resolve().parent
    except (OSError, TypeError):  # typed into a console
        return None
