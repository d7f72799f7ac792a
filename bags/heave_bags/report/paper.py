"""A report on paper: the PDF of a page, made by an installed Chromium without a window."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
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


def find_browser() -> str:
    """Return the path of an installed Chromium, Chrome or Edge.

    Raises BagError, saying what to do, where there is none.
    """
    found = next((path for name in NAMES if (path := shutil.which(name))), "")
    found = found or next((place for place in PLACES if Path(place).is_file()), "")
    if not found:
        raise BagError(
            "no Chromium, Chrome or Edge is installed here, which a PDF needs: install one (apt install "
            "chromium), or open report.html in any browser and print it"
        )
    return found


def save_pdf(page: Path, output: Path) -> None:
    """Print the HTML file `page` to the PDF file `output`, A4 as the page's style sheet says.

    Raises BagError where no browser is installed, or it gives no PDF.
    """
    browser = find_browser()
    as_root = ["--no-sandbox"] if hasattr(os, "geteuid") and os.geteuid() == 0 else []  # it refuses to start else
    output.unlink(missing_ok=True)
    with tempfile.TemporaryDirectory(prefix="heave-browser-", ignore_cleanup_errors=True) as profile:
        own = [f"--user-data-dir={profile}", f"--print-to-pdf={output.resolve()}"]
        command = [browser, *FLAGS, *as_root, *own, page.resolve().as_uri()]
        try:
            done = subprocess.run(command, capture_output=True, timeout=LONGEST, check=False)
        except (OSError, subprocess.TimeoutExpired) as error:
            raise BagError(f"{output}: {browser} did not draw the page: {error}") from error
    if not output.is_file() or not output.stat().st_size:
        said = done.stderr.decode(errors="replace").strip().splitlines() or [f"exit status {done.returncode}"]
        raise BagError(f"{output}: {browser} wrote nothing: {said[-1]}")
