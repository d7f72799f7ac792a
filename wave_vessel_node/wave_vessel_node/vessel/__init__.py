"""The vessel: from sea to boom-tip motion by RAO, by a second-order filter, or from a recording."""

from heave_node.compiled import drop_stale_kernels

drop_stale_kernels(__file__)
