"""What figures of merit are made of: a definition, a window of a run, the sources of its motions."""
