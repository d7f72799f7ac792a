"""What a record holds as signals: readings, the boom tip, spectra, what no model explains."""
