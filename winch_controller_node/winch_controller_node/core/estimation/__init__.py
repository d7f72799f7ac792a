"""Estimation: from readings to the estimated state, with the health of each sensor and the sea that is there."""
