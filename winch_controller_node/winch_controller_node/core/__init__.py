"""What runs in each tick: estimation, supervision, the order."""
