"""Entrants that come with the benchmark: baselines, published laws, and this suite's own laws by the same door."""
