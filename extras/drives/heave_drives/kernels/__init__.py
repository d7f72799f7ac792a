"""The compiled loops of the drives, and the mechanics that they share."""

from heave_node.numerics.compiled import drop_stale_kernels

from cable_sim_node import winch

drop_stale_kernels(__file__, winch.__file__)
