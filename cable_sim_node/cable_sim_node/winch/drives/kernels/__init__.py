"""The compiled loops of the drives, and the mechanics that they share."""

from heave_node.compiled import drop_stale_kernels

drop_stale_kernels(__file__)
