"""What acts on the line: tension of its segments, bending, moving water, seabed, compensator."""

from heave_node import numerics
from heave_node.numerics.compiled import drop_stale_kernels

from cable_sim_node import line, physics

drop_stale_kernels(__file__, line.__file__, physics.__file__, numerics.__file__)
