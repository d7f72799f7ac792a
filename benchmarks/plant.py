"""How fast the plant is and how wrong, beside MoorDyn in the same run.

    python benchmarks/plant.py [SEGMENTS ...] [--json]

Prints one line per number of segments; `--json` prints the list of `measure_plant` instead.
"""

from __future__ import annotations

import argparse
import json

from cable_sim_node.plant_benchmark import measure_plant

__all__ = ["measure_plant"]


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("segments", nargs="*", type=int, default=[20, 50, 100, 200])
    parser.add_argument("--json", action="store_true", help="print JSON and nothing else")
    arguments = parser.parse_args()
    rows = measure_plant(arguments.segments)
    if arguments.json:
        print(json.dumps(rows))
        return
    print("segments   ms per simulated s   times real time   error %   MoorDyn's time over ours")
    for row in rows:
        own = row["ms_per_simulated_s"]
        print(
            f"{row['segments']:8.0f}   {own:18.3f}   {1e3 / own:15.0f}   {row['error_percent']:7.4f}   "
            f"{row['ratio_to_moordyn']:24.1f}"
        )


if __name__ == "__main__":
    main()
