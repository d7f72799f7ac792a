"""Which winch: sweeps of its size against the seas that one can work in."""
