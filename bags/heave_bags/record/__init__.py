"""Recording: the recorder of a run and the one on its own."""
