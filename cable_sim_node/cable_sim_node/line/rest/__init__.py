"""The line at rest, exactly in equilibrium: hanging, or settled on the seabed."""

from heave_node import numerics
from heave_node.numerics.compiled import drop_stale_kernels

from cable_sim_node import line, physics
from cable_sim_node.line import forces

drop_stale_kernels(__file__, line.__file__, forces.__file__, physics.__file__, numerics.__file__)
