"""Cable, unit and MRU by the whole record."""
