"""The line in three dimensions: its compiled kernels, its dynamics, its equilibrium and its small motion."""

from heave_node import numerics
from heave_node.numerics.compiled import drop_stale_kernels

from cable_sim_node import physics
from cable_sim_node.line import forces

drop_stale_kernels(__file__, forces.__file__, physics.__file__, numerics.__file__)
