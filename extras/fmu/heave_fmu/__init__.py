"""Parts of the loop as FMUs for co-simulation (FMI 2.0), and FMUs in the place of a part."""
