"""Drives of a winch behind one interface: the speed servo, and those that extras bring."""

from heave_node.numerics.compiled import drop_stale_kernels

drop_stale_kernels(__file__)
