"""Sources of the vessel's motion: sums of components, filtered noise, a sine, recordings; and what lies over them."""

from heave_node.numerics.compiled import drop_stale_kernels

drop_stale_kernels(__file__)
