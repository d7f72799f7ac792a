"""Build the validation gallery: run `tests/validation` with drawing switched on and write one page with every figure.

    python benchmarks/gallery.py docs/gallery

The site (`make docs`) shows the page where it finds it; the few figures in `docs/pictures/thesis` are drawn again too.

Every figure comes from the run that its test has just judged, so the page shows the state of the code, not of a
memory. Exits with pytest's status; the page is written even when a test fails.
"""

from __future__ import annotations

import argparse
import html
import json
import os
import subprocess
import sys
from pathlib import Path

from PIL import Image  # comes with matplotlib, which draws the figures

PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>Validation gallery</title>
<style>
body {{ font-family: sans-serif; max-width: 60em; margin: 2em auto; }}
img {{ max-width: 100%; }}
code {{ color: #555; }}
</style>
</head><body>
<h1>Validation gallery</h1>
{figures}
</body></html>
"""


def write_index(folder: Path) -> int:
    """Write `index.html` for the figures in `folder`; return how many there are."""
    blocks = []
    for picture in sorted(folder.glob("*.png")):
        entry = json.loads(picture.with_suffix(".json").read_text(encoding="utf-8"))
        title, caption, test = (html.escape(text) for text in (picture.stem, entry["caption"], entry["test"]))
        blocks.append(
            f'<h2 id="{title}">{title.replace("_", " ")}</h2>\n'
            f'<img src="{title}.png" alt="{caption}">\n<p>{caption}<br><code>{test}</code></p>'
        )
    (folder / "index.html").write_text(PAGE.format(figures="\n".join(blocks)), encoding="utf-8")
    return len(blocks)


def renew_small_copies(figures: Path, small: Path) -> int:
    """Draw each picture in the folder `small` again from the figure of its name in `figures`; return how many."""
    renewed = [path for path in sorted(small.glob("*.png")) if (figures / path.name).is_file()]
    for path in renewed:
        with Image.open(figures / path.name) as figure:
            colours = figure.convert("RGB").resize((704, round(704 * figure.height / figure.width)), Image.LANCZOS)
            colours.quantize(24, dither=Image.Dither.NONE).save(path, optimize=True)
    return len(renewed)


def main() -> int:
    """Run the validation tests with drawing on and write the page."""
    parser = argparse.ArgumentParser(description="Build the validation gallery.")
    parser.add_argument("folder", type=Path, nargs="?", default=Path("docs/gallery"), help="where the page goes")
    parser.add_argument("--select", default="", help="pytest -k expression, to draw some of the figures only")
    arguments = parser.parse_args()
    folder = arguments.folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    root = Path(__file__).resolve().parent.parent
    command = [sys.executable, "-m", "pytest", "tests/validation"]
    if arguments.select:
        command += ["-k", arguments.select]
    status = subprocess.run(command, cwd=root, env={**os.environ, "HEAVE_GALLERY": str(folder)}, check=False).returncode
    print(f"{renew_small_copies(folder, root / 'docs' / 'pictures' / 'thesis')} pictures of the site drawn anew")
    print(f"{write_index(folder)} figures in {folder / 'index.html'}")
    return status


if __name__ == "__main__":
    sys.exit(main())
