"""A report on paper: PDF and pictures of a page, made by an installed Chromium without a window."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path

from heave_bags.errors import BagError

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "microsoft-edge", "msedge")
"""Programs that print a page, in the order in which they are looked for."""
PLACES = (
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
)
"""Places of browsers on macOS, outside the search path."""
FLAGS = (
    *("--headless", "--disable-gpu", "--no-first-run", "--hide-scrollbars", "--disable-extensions", "--disable-sync"),
    *("--disable-background-networking", "--disable-component-update", "--no-pdf-header-footer"),
    "--virtual-time-budget=30000",  # until the page has drawn its figures
)
LONGEST = 180.0
"""Wall time after which a browser is given up [s]."""
PICTURE = (1200, 1080)
"""Window of a picture [pixels]."""


def find_browser() -> str:
    """Return the path of an installed Chromium, Chrome or Edge.

    Raises BagError, saying what to do, where there is none.
    """
    found = next((path for name in NAMES if (path := shutil.which(name))), "")
    found = found or next((place for place in PLACES if Path(place).is_file()), "")
    if not found:
        raise BagError(
            "no Chromium, Chrome or Edge is installed here, which a PDF or picture needs: install one (apt install "
            "chromium), or open report.html in any browser and print it"
        )
    return found


def save_pdf(page: Path, output: Path) -> None:
    """Print the HTML file `page` to the PDF file `output`, A4 as the page's style sheet says.

    Raises BagError where no browser is installed, or it gives no PDF.
    """
    _draw(page, output, [f"--print-to-pdf={output.resolve()}"])


def save_picture(page: Path, output: Path, size: tuple[int, int] = PICTURE) -> None:
    """Save the head of the HTML file `page` as the PNG file `output`, `size` pixels wide and high.

    Raises BagError as `save_pdf` does.
    """
    _draw(page, output, [f"--screenshot={output.resolve()}", f"--window-size={size[0]},{size[1]}"])


def _draw(page: Path, output: Path, options: Sequence[str]) -> None:
    """Let a browser open the `page` and write the `output` that its `options` name."""
    browser = find_browser()
    as_root = ["--no-sandbox"] if hasattr(os, "geteuid") and os.geteuid() == 0 else []  # it refuses to start else
    output.unlink(missing_ok=True)
    with tempfile.TemporaryDirectory(prefix="heave-browser-", ignore_cleanup_errors=True) as profile:
        command = [browser, *FLAGS, *as_root, f"--user-data-dir={profile}", *options, page.resolve().as_uri()]
        try:
            done = subprocess.run(command, capture_output=True, timeout=LONGEST, check=False)
        except (OSError, subprocess.TimeoutExpired) as error:
            raise BagError(f"{output}: {browser} did not draw the page: {error}") from error
    if not output.is_file() or not output.stat().st_size:
        said = done.stderr.decode(errors="replace").strip().splitlines() or [f"exit status {done.returncode}"]
        raise BagError(f"{output}: {browser} wrote nothing: {said[-1]}")
