"""Arrays, constants, random numbers, linear models, spectra: what calculates, and knows of no message."""
