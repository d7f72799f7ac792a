"""The draws of the promise by their former options: `heave study few|stacked|seas|lifts` runs them.

python -m tests.campaigns.draws --kind stacked --draws 40 --seed 20261126 --workers 1
"""

from __future__ import annotations

import argparse
import sys

from heave_bringup.cli import main

OPTIONS = {"draws": "--draws={}", "workers": "--processes={}", "seed": "--ask=seed={}", "only": "--ask=only=[{}]",
           "without": "--ask=without=[{}]", "against": "--ask=against={}", "output": "--output={}"}  # fmt: skip
"""Options of this command, and those of the study."""

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kind", choices=("few", "stacked", "seas", "lifts"), default="few")
    for name in OPTIONS:
        parser.add_argument(f"--{name}")
    options = vars(parser.parse_args())
    words = [text.format(options[name]) for name, text in OPTIONS.items() if options[name] is not None]
    sys.exit(main(["study", options["kind"], *words]))
