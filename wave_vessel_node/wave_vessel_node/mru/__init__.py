"""The motion reference unit: its sensor, its faults, and the sea state estimated from its record."""
