"""Drives of a winch with their physics: electric, pump-controlled and valve-controlled hydraulic."""
