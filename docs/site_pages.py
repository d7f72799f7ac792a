"""What the documentation site takes from the rest of the repository: a hook of mkdocs (`docs/mkdocs.yml`).

A README stays where its package is and is a page of the site as well; commands, topics, messages and figures of merit
are written from the code that runs. A link is read as the repository has it, from the page's own file: one to another
page becomes a link of the site, one to what a page is written from a link to that page, one to another source file its
name. One that leads nowhere is a warning, which `--strict`
makes an error.
"""

from __future__ import annotations

import importlib
import inspect
import json
import logging
import os
import re
from pathlib import Path
from posixpath import relpath
from typing import Any

from mkdocs.structure.files import File, Files

REPOSITORY = Path(__file__).resolve().parents[1]
GUIDE = REPOSITORY / "docs" / "guide"
NOTEBOOKS = REPOSITORY / "docs" / "notebooks"

PAGES = {
    "README.md": "overview.md",
    "ARCHITECTURE.md": "explanation/architecture.md",
    "CONTRIBUTING.md": "reference/contributing.md",
    "CHANGELOG.md": "reference/changelog.md",
    "docs/parameters.md": "reference/parameters.md",
    "docs/modes.md": "reference/modes.md",
    "docs/alarms.md": "reference/alarms.md",
    "docs/hazards.md": "reference/hazards.md",
    "docs/fault_matrix.md": "reference/fault_matrix.md",
    "docs/contract.md": "reference/contract.md",
    "docs/core.md": "reference/core.md",
    "bags/README.md": "reference/bags.md",
    "bringup/README.md": "packages/bringup.md",
    "bringup/heave_bringup/scenarios/README.md": "reference/scenarios.md",
    "cable_sim_node/README.md": "packages/cable_sim.md",
    "extras/drives/README.md": "packages/drives.md",
    "msgs/README.md": "packages/msgs.md",
    "node_base/README.md": "packages/node_base.md",
    "wave_vessel_node/README.md": "packages/wave_vessel.md",
    "winch_controller_node/README.md": "packages/winch_controller.md",
    "tests/validation/README.md": "validation/claims.md",
}
"""Pages that stand elsewhere, by their path in the repository: where the site has them."""
WRITTEN_FROM = {
    "bringup/heave_bringup/commands": "reference/commands.md",
    "node_base/heave_node/interface/topics.py": "reference/topics.md",
    "msgs/msg": "reference/messages.md",
    "bags/heave_bags/analyse/kpi_set.py": "reference/figures_of_merit.md",
    **{f"docs/notebooks/{path.name}": f"notebooks/{path.stem}.md" for path in NOTEBOOKS.glob("*.ipynb")},
}
"""Page of the site for each document, by its path in the repository, where a link of a document leads."""
PICTURES = ("docs/architecture.svg", "docs/pictures/*", "docs/pictures/thesis/*", "cable_sim_node/pictures/*.svg")
"""Pictures of the repository; the site has them in `pictures/`."""
GALLERY = REPOSITORY / "docs" / "gallery"
"""Every figure of the validation, where `make gallery` has drawn them: the site shows them then."""
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^()\s]+)\)")
BLOCK = re.compile(r"(^ *```.*?^ *```)", re.DOTALL | re.MULTILINE)

log = logging.getLogger("mkdocs.site_pages")


def pictures() -> dict[str, str]:
    """Return the pictures by their path in the repository, with their place in the site."""
    found = sorted(path for pattern in PICTURES for path in REPOSITORY.glob(pattern) if path.is_file())
    return {path.relative_to(REPOSITORY).as_posix(): f"pictures/{path.name}" for path in found}


def on_files(files: Files, config: Any) -> Files:
    """Add the pages that stand elsewhere, the pictures, and what is written from the code."""
    for path, place in {**PAGES, **pictures()}.items():
        files.append(File.generated(config, place, abs_src_path=str(REPOSITORY / path)))
    for place, text in written_pages():
        files.append(File.generated(config, place, content=text))
    for path in sorted(GALLERY.glob("*.png")):
        files.append(File.generated(config, f"gallery/{path.name}", abs_src_path=str(path)))
    return files


def on_page_markdown(markdown: str, page: Any, config: Any, files: Files) -> str:  # noqa: ARG001 (mkdocs names them)
    """Turn the links of a page from those of the repository into those of the site."""
    place = page.file.src_uri
    origin = next((REPOSITORY / path for path, at in PAGES.items() if at == place), GUIDE / place)
    if not origin.is_file():
        return markdown  # written from the code, by the site's own places
    parts = BLOCK.split(markdown)
    return "".join(part if index % 2 else _with_links_of_site(part, origin, place) for index, part in enumerate(parts))


def _with_links_of_site(text: str, origin: Path, place: str) -> str:
    """Return a text without blocks of code in which each link is one of the site.

    Parameters
    ----------
    text : Markdown
    origin : file that it stands in
    place : of its page in the site
    """

    def replaced(found: re.Match[str]) -> str:
        mark, words, target = found.groups()
        if re.match(r"[a-z]+:|#", target):
            return found[0]
        words = LINK.sub(replaced, words) if words.startswith("![") else words
        path, _, anchor = target.partition("#")
        address = site_place(origin, path)
        if address:
            return f"{mark}[{words}]({relpath(address, Path(place).parent.as_posix())}{'#' + anchor if anchor else ''})"
        if not (origin.parent / path).exists():
            log.warning("%s links to %s, which is not there", origin.relative_to(REPOSITORY), target)
        return words if words.startswith("`") else f"*{words}*"

    return LINK.sub(replaced, text)


def site_place(origin: Path, path: str) -> str:
    """Return where the site has what a link leads to; "" where the site has it not.

    Parameters
    ----------
    origin : file that the link stands in
    path : as written there, without anchor
    """
    target = Path(os.path.normpath(origin.parent / path))
    if target.is_relative_to(GUIDE):
        return target.relative_to(GUIDE).as_posix() if target.is_file() else ""
    if not target.is_relative_to(REPOSITORY):
        return ""
    places = {**PAGES, **WRITTEN_FROM, **pictures()}
    inside = target.relative_to(REPOSITORY).as_posix()
    return places.get(inside) or places.get(f"{inside}/README.md", "")


_written: list[tuple[str, str]] = []


def written_pages() -> list[tuple[str, str]]:
    """Return what is written from the code: place in the site, and Markdown."""
    if not _written:
        _written.extend(
            [
                ("reference/commands.md", commands_page()),
                ("reference/topics.md", topics_page()),
                ("reference/messages.md", messages_page()),
                ("reference/python.md", python_page()),
                ("reference/figures_of_merit.md", figures_of_merit_page()),
                ("validation/gallery.md", gallery_page()),
                *((f"notebooks/{path.stem}.md", notebook_page(path)) for path in sorted(NOTEBOOKS.glob("*.ipynb"))),
            ]
        )
    return _written


def commands_page() -> str:
    """Return the help of every command, with its examples."""
    from heave_bringup.commands.command import name_of  # noqa: PLC0415 (the site is the only one that needs it)
    from heave_bringup.errors import status_table  # noqa: PLC0415 (as below)
    from heave_bringup.parser import all_commands, make_parser  # noqa: PLC0415

    os.environ["COLUMNS"] = "100"  # the width of the help
    subparsers = make_parser()._subparsers
    assert subparsers is not None
    (chosen,) = (action for action in subparsers._group_actions if action.choices)
    parsers = dict(chosen.choices or {})
    parts = ["# Commands", "What `heave COMMAND --help` prints.", status_table()]
    names = {name_of(command): command for command in all_commands()}
    parts += [", ".join(f"[{name}](#heave-{name})" for name in names)]
    for name, command in names.items():
        usage = parsers[name].format_help().partition("\nexample: ")[0].rstrip()
        parts += [f"## heave {name}", f"```text\n{usage}\n```"]
        parts += ["```sh\n" + "\n".join(command.EXAMPLES) + "\n```"] if command.EXAMPLES else []
    return "\n\n".join(parts) + "\n"


def topics_page() -> str:
    """Return the table of topics."""
    from heave_node.interface.topics import ALL_TOPICS  # noqa: PLC0415 (as above)

    lines = ["# Topics", ""]
    lines += ["Names are relative to the namespace of the run. What a field means: [messages](messages.md); how a node"]
    lines += ["of yours joins in: [external nodes](contract.md).", ""]
    lines += ["| topic | type | published by | carried |", "|---|---|---|---|"]
    for topic in sorted(ALL_TOPICS, key=lambda topic: topic.name):
        kind = topic.type
        if kind.startswith("heave_msgs/"):
            kind = f"[`{kind}`](messages.md#{kind.rpartition('/')[2].lower()})"
        else:
            kind = f"`{kind}`"
        publisher = f"`{topic.publisher}`" if topic.publisher else "several"
        lines.append(f"| `{topic.name}` | {kind} | {publisher} | {topic.role.value} |")
    lines += ["", "A stream and a command are reliable and volatile; a latched topic is transient local."]
    return "\n".join(lines) + "\n"


def messages_page() -> str:
    """Return every message, service and action as its file defines it."""
    parts = ["# Messages, services and actions", "Units, frames and signs stand beside each field."]
    for folder, title in (("msg", "Messages"), ("srv", "Services"), ("action", "Actions")):
        parts.append(f"## {title}")
        for path in sorted((REPOSITORY / "msgs" / folder).glob(f"*.{folder}")):
            parts += [f"### {path.stem}", f"```text\n{path.read_text(encoding='utf-8').rstrip()}\n```"]
    return "\n\n".join(parts) + "\n"


def python_page() -> str:
    """Return what each package offers by its own name: signature and docstring."""
    packages = (
        "heave_bringup",
        "heave_bags",
        "winch_controller_node",
        "cable_sim_node",
        "wave_vessel_node",
        "heave_node",
    )
    parts = [
        "# Python",
        "What a program imports from the packages themselves; everything is typed. Reading bags, models and",
    ]
    parts[-1] += " design need no ROS. In use: [notebooks](../notebooks/first_analysis.md)."
    for package in packages:
        face = importlib.import_module(package)
        parts += [f"## {package}", (inspect.getdoc(face) or "").partition("\n")[0]]
        for name in sorted(getattr(face, "__all__", ())):
            thing = getattr(face, name)
            try:
                signature = str(inspect.signature(thing))
            except (TypeError, ValueError):
                signature = ""
            parts += [f"### {name}", f"```text\n{name}{signature}\n\n{inspect.getdoc(thing) or ''}\n```"]
    return "\n\n".join(parts) + "\n"


def figures_of_merit_page() -> str:
    """Return the table of figures of merit."""
    from heave_bags.analyse.kpi_set import GROUPS, KPI_DEFINITIONS  # noqa: PLC0415 (as above)

    lines = ["# Figures of merit", ""]
    lines += [
        "What `heave run`, `heave kpi` and a report give of a run. The key is its name in `--json`, in `--require`"
    ]
    lines += ["and in the `wanted` of a scenario, and ends in the SI unit that these use; tables show it in the unit"]
    lines += ["beside it. Terms: [a run](../explanation/a_run.md#terms-in-the-tables). Formulas are in"]
    lines += ["`heave_node/kpi.py`, each with its source.", ""]
    for group in GROUPS:
        lines += [f"## {group}", "", "| key | meaning | symbols | shown in |", "|---|---|---|---|"]
        lines += [
            f"| `{one.key}` | {one.title} | {one.symbols.replace('|', chr(92) + '|')} | {one.unit} |"
            for one in KPI_DEFINITIONS
            if one.group == group
        ]
        lines.append("")
    return "\n".join(lines)


def gallery_page() -> str:
    """Return every figure that `make gallery` has drawn; where it has not, how to."""
    parts = ["# The gallery", "Every figure of the validation, drawn by the run that its test has just judged."]
    entries = sorted(GALLERY.glob("*.json"))
    if not entries:
        parts.append("None are here: `make gallery` draws them in ten minutes, then `make docs` shows them.")
        parts.append("Those of the thesis are on [a page of their own](thesis.md).")
    for path in entries:
        entry = json.loads(path.read_text(encoding="utf-8"))
        picture = f"![{entry['caption']}](../gallery/{path.stem}.png)"
        parts += [f"## {path.stem.replace('_', ' ')}", picture, f"{entry['caption']} `{entry['test']}`"]
    return "\n\n".join(parts) + "\n"


def notebook_page(path: Path) -> str:
    """Return the cells of a notebook, and how to run it."""
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    parts = []
    for cell in cells:
        text = "".join(cell["source"])
        parts.append(text if cell["cell_type"] == "markdown" else f"```python\n{text}\n```")
    hint = f"`docs/notebooks/{path.name}`: run and change it in Jupyter (`pip install jupyterlab`)."
    return "\n\n".join([parts[0], hint, *parts[1:]]) + "\n"
