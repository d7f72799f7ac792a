"""What an entrant is tried on: plants, winches, loads and motions."""
