"""The fixed controller as an FMU of C alone."""
