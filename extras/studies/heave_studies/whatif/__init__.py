"""What would have been: another law, gain or winch in the sea of a record, from its sensors alone."""
