"""Analysis: from a bag to signals, KPIs, verdict and tables."""
