"""A live stream of a run for Foxglove, on this machine."""
