"""Nodes of others in the place of a node of the suite: the contract, the check against it, a clock for a ship."""
