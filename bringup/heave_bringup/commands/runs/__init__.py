"""Commands that run the nodes."""
