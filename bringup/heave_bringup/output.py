"""What commands print: a text for people, or JSON and nothing else on standard output for machines."""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from heave_node.parameters import ParameterError

from heave_bringup.errors import CommandError


def write_result(options: argparse.Namespace, text: str, result: Mapping[str, object]) -> None:
    """Print the text for people, unless standard output belongs to the JSON, and write the JSON where it was asked
    for.
    """
    document = json.dumps(_finite(result), indent=2) + "\n" if options.json else ""
    if options.json == "-":
        sys.stdout.write(document)
        return
    sys.stdout.write(text if text.endswith("\n") else text + "\n")
    if options.json:
        try:
            Path(options.json).write_text(document, encoding="utf-8")
        except OSError as error:
            raise CommandError(f"{options.json}: cannot be written: {error.strerror}") from error


def check_output(option: str, path: Path | None, endings: Sequence[str], *, makes_folder: bool = False) -> None:
    """Refuse an output file that could not be written, before the work for it begins; None is no file.

    Raises ParameterError, naming the option, for another ending than `endings`, or for a folder that does not exist
    unless the command makes it.
    """
    if path is None:
        return
    if path.suffix.lower() not in endings:
        raise ParameterError(f"{option} {path}: must end in {' or '.join(endings)}")
    if not makes_folder and not path.resolve().parent.is_dir():
        raise ParameterError(f"{option} {path}: there is no folder {path.parent}")


def _finite(value: object) -> object:
    """Return the value with every NaN and infinity as None: JSON knows neither."""
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, Mapping):
        return {str(key): _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return value
