"""Files of all makes, whole or damaged: found, scanned, put in order, decoded."""
