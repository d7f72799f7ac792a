"""The controller as an FMU without Python."""
