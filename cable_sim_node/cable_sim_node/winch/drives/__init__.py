"""Drives of a winch: speed servo, electric, pump-controlled and valve-controlled hydraulic, behind one interface."""

from heave_node.numerics.compiled import drop_stale_kernels

drop_stale_kernels(__file__)
