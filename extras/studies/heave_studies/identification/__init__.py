"""Identification: the two-state cable from a response, the winch's lags from what it was sent and what it did."""

from heave_node.numerics.compiled import drop_stale_kernels

drop_stale_kernels(__file__)
