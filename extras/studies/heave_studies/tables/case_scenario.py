"""A case of a table as a scenario file, with the files that it read and that are gone: fit for `heave run`."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from heave_bringup.scenarios import NAMES_OF_FILES, Scenario, load_scenario, write_scenario
from heave_node.parameters import ParameterError
from heave_node.scenario import parse_sections, sections_text

from heave_studies.tables.case_table import files_of, scenario_of, split_reference
from heave_studies.tables.kept_files import make_good


def write_case(reference: str, path: Path | None = None) -> tuple[Path, list[str]]:
    """Write the scenario of a case, and return its file and a line on each file that was made again.

    Files that are not where they were, or not as they were, are written beside it, into `NAME_files`.

    Parameters
    ----------
    reference : FILE.parquet:CASE
    path : of the scenario file; None: `FILE_case_CASE.yaml` in the working folder

    Raises ParameterError for what is no case, and for a file that was too large for the table to keep it.
    """
    case = split_reference(reference)
    if case is None:
        raise ParameterError(f"--case {reference}: must be FILE.parquet:CASE, for example table.parquet:17")
    path = path or Path(f"{case[0].stem}_case_{case[1]}.yaml")
    text = scenario_of(*case)
    sections = parse_sections(text.encode(), reference)
    values = [of for section in sections.values() for of in section.items()]
    named = [str(value) for name, value in values if name.endswith(NAMES_OF_FILES) and value]
    read, kept = files_of(*case)
    anew, reported = make_good(read, kept, named, path.with_name(f"{path.stem}_files"), reference)
    for section in sections.values():
        for name, value in section.items():
            if isinstance(value, str) and value in anew:
                section[name] = Path(os.path.relpath(anew[value], path.resolve().parent)).as_posix()
    title = "\n".join(line.lstrip("# ") for line in text.splitlines() if line.startswith("#"))
    write_scenario(path, sections_text(sections, title=title))
    return path, reported


def load_case(table: Path, number: int) -> Scenario:
    """Return the scenario of case `number` in a `table`, to be looked at: files that it names need not be there.

    Raises ParameterError for a table or a case that is not there.
    """
    with tempfile.TemporaryDirectory(prefix="heave-") as folder:
        file = Path(folder) / f"{table.stem}_case_{number}.yaml"
        file.write_text(scenario_of(table, number), encoding="utf-8")
        return load_scenario(str(file), needs_files=False)
