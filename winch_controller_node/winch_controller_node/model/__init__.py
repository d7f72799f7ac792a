"""Models: linear state space, the parts of the loop, regulator and Kalman filter."""

from heave_node.numerics.compiled import drop_stale_kernels

drop_stale_kernels(__file__)
