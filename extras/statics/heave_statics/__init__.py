"""Statics of marine cables: an elastic cable in three dimensions under weight, point loads and current.

The shape is a function of three unknowns, the tension vector at the end s = 0; everything else follows in closed form
from segment to segment. Start at `problems` (submerged, towing, mooring), `footprint` and `laying`.
"""

from heave_node.numerics.compiled import drop_stale_kernels

from cable_sim_node import physics

drop_stale_kernels(__file__, physics.__file__)
