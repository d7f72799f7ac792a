"""The formulas that all models of the cable share, each defined once: weight, tension law, drag, current."""

from heave_node.numerics.compiled import drop_stale_kernels

drop_stale_kernels(__file__)
