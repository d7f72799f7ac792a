"""The virtual winch: its drive, its drum, its parameters."""

from heave_node.numerics.compiled import drop_stale_kernels

drop_stale_kernels(__file__)
