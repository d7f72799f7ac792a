"""The search for what breaks the promise: the worst minute of a scenario that no alarm announces."""
