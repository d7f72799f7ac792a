"""Import the packages whose folder has their own name before the tests are collected.

Pytest's importlib mode names a test after its folders (`cable_sim_node.test.test_x`) and would put a namespace
package of the folder in the place of the package of that name.
"""

import importlib
from contextlib import suppress

for package in ("cable_sim_node", "wave_vessel_node", "winch_controller_node"):
    with suppress(ModuleNotFoundError):  # colcon tests a package where only those that it depends on are at hand
        importlib.import_module(package)
