"""The mean motion: where compensation works about, how it goes to another depth, and the programme of a run."""
