"""The `heave` command."""

from __future__ import annotations

from heave_bringup.interrupts import forget_interrupts, raise_if_interrupted, raise_interrupts  # notes them from now on

# isort: split
import argparse
import errno
import os
import sys
from collections.abc import MutableMapping, Sequence
from pathlib import Path

from heave_bags.errors import BagError, NoBagError
from heave_node.parameters import ParameterError
from heave_node.ros.transport.parents_death import exit_at_once
from heave_node.ros.transport.watchdog import check_memory

from heave_bringup.commands.arguments import complete
from heave_bringup.errors import CommandError, ExitStatus

FULL = (errno.ENOSPC, errno.EDQUOT)
"""Errors of a disk that is full: they come without the file's name."""
_OF_ROS = {"LD_LIBRARY_PATH": ["librcl.so"], "AMENT_PREFIX_PATH": ["share/rclpy"]}
"""Variables that the setup of a ROS extends beside PYTHONPATH, and what one of their folders holds where it does."""
_COMPILED = ("rclpy", "heave_msgs", "numpy")
"""Modules that must be this installation's own, where it has them."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the `heave` command with `arguments`, without the program's name; None: those of this process.

    Returns its `ExitStatus`: 0 only when it did what it says and no verdict is FAILED.
    """
    try:
        raise_interrupts()  # nodes are ended in order
        if words := leave_out_other_ros(os.environ, sys.path):
            sys.stderr.write(f"heave: {words}\n")
            if arguments is None and "LD_LIBRARY_PATH" in words:  # which the loader reads at the start of a process
                os.execv(sys.executable, sys.orig_argv)
        return _main(arguments)
    except KeyboardInterrupt:
        return _exit_with("interrupted", ExitStatus.INTERRUPTED)
    finally:
        forget_interrupts()


def _main(arguments: Sequence[str] | None) -> int:
    from heave_bringup.parser import make_parser  # noqa: PLC0415 - after what hides this installation's is left out

    parser = make_parser(sys.argv[1:] if arguments is None else arguments)
    complete(parser)
    options = parser.parse_args(arguments)
    status = _status_after(options)
    if arguments is None and status == ExitStatus.INTERRUPTED:
        exit_at_once(status)
    return status


def _status_after(options: argparse.Namespace) -> int:
    """Execute the command; return its exit status, with a line on standard error where it is not DONE."""
    try:
        _execute(options)
    except (CommandError, ParameterError, BagError, MemoryError) as error:
        return _exit_with(str(error) or "out of memory", _status_of(error))
    except KeyboardInterrupt:
        return _exit_with("interrupted", ExitStatus.INTERRUPTED)
    except OSError as error:
        return _refused_by_the_system(error)
    return ExitStatus.DONE


def _execute(options: argparse.Namespace) -> None:
    raise_if_interrupted()
    if options.json not in (None, "-"):
        from heave_bringup.output import check_output  # noqa: PLC0415 - slow to import, and seldom needed here

        check_output("--json", Path(options.json))
    try:
        options.execute(options)
    except (CommandError, ParameterError, BagError):
        raise
    except ModuleNotFoundError as error:
        from heave_bringup.commands.extras import missing  # noqa: PLC0415 - seldom needed

        raise missing(options.command, error) from error
    except Exception:  # libraries name a lack of memory in many ways
        check_memory()
        raise


def _status_of(error: Exception) -> ExitStatus:
    if isinstance(error, CommandError):
        return error.status
    return ExitStatus.REFUSED if isinstance(error, ParameterError | NoBagError) else ExitStatus.FAILED


def _exit_with(error: object, status: ExitStatus) -> ExitStatus:
    sys.stderr.write(f"heave: {error}\n")
    return status


def _refused_by_the_system(error: OSError) -> int:
    if isinstance(error, BrokenPipeError):  # the reader of our output has closed it
        return ExitStatus.FAILED
    if error.filename is None and error.errno not in FULL:  # no file that the user named: a defect of ours, in full
        raise error
    help_ = "; free space there or write elsewhere" if error.errno in FULL else ""
    return _exit_with(f"{error.filename or 'output'}: {error.strerror}{help_}", ExitStatus.FAILED)


def leave_out_other_ros(environment: MutableMapping[str, str], path: list[str]) -> str:
    """Take folders with another ROS or compiled module out of the `environment` and off the `path` of modules.

    Returns in words which, "" where there is none. Where the suite has no ROS but that of PYTHONPATH, as built by
    colcon, that one stays.
    """
    given = [Path(folder).absolute() for folder in environment.get("PYTHONPATH", "").split(os.pathsep) if folder]
    own = [Path(folder) for folder in path if folder and Path(folder) not in given]
    hidden = [name for name in _COMPILED if any((folder / name).is_dir() for folder in own)]
    if "rclpy" not in hidden:
        return ""
    marks = {"PYTHONPATH": hidden, **_OF_ROS}
    others = {name: _others(environment.get(name, ""), marks[name]) for name in marks}
    middleware, libraries = environment.get("RMW_IMPLEMENTATION"), Path(sys.prefix) / "lib"
    if middleware and (libraries / "librmw.so").exists() and not (libraries / f"lib{middleware}.so").exists():
        others["RMW_IMPLEMENTATION"] = [middleware]
    others = {name: folders for name, folders in others.items() if folders}
    for name, folders in others.items():
        kept = [folder for folder in environment.pop(name).split(os.pathsep) if folder not in folders]
        environment.update({name: os.pathsep.join(kept)} if kept else {})
    taken = [Path(folder).absolute() for folder in others.get("PYTHONPATH", ())]
    path[:] = [folder for folder in path if Path(folder) not in taken]
    found = "; ".join(f"{name} {', '.join(folders)}" for name, folders in others.items())
    return f"what hides this installation's rclpy, heave_msgs or numpy is left out: {found}" if found else ""


def _others(folders: str, marks: Sequence[str]) -> list[str]:
    """Return those of the `folders` of a variable that hold one of `marks` and are not of this installation."""
    own = Path(sys.prefix)
    every = [folder for folder in folders.split(os.pathsep) if folder and not Path(folder).is_relative_to(own)]
    return [folder for folder in every if any((Path(folder) / mark).exists() for mark in marks)]


if __name__ == "__main__":
    sys.exit(main())
