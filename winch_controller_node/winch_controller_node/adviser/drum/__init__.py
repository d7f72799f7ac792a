"""The drum of the winch, identified from what it was ordered and what its encoder read."""
