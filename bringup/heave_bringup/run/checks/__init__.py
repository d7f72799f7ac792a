"""What a run is refused for before any node starts."""
