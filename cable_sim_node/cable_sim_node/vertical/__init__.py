"""Vertical motion alone: the axial cable of changing length, its linear models, the two-state plant."""

from heave_node.numerics.compiled import drop_stale_kernels

drop_stale_kernels(__file__)
