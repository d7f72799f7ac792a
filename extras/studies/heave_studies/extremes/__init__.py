"""Extremes of a stationary sea: maxima of records, their distributions, and what is to be expected of longer times."""
