"""Many cases at once, screened by the plant's own kernels under a fixed law; what that does not cover runs in full."""

from cable_sim_node.line import forces
from heave_node import numerics
from heave_node.numerics.compiled import drop_stale_kernels

from cable_sim_node import line, physics, winch

drop_stale_kernels(__file__, line.__file__, forces.__file__, physics.__file__, winch.__file__, numerics.__file__)
