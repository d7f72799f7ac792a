"""The line in three dimensions: its compiled kernels, its dynamics and its equilibrium."""

from heave_node.compiled import drop_stale_kernels

drop_stale_kernels(__file__)
