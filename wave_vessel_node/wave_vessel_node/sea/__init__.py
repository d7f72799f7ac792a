"""The sea: spectra, files of spectra, realisations, shaping filters."""

from heave_node.numerics.compiled import drop_stale_kernels

drop_stale_kernels(__file__)
