"""Who can reach a node and whom it listens to, and what its process asks of the machine."""
