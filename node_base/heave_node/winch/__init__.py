"""What plant and controller know alike of a winch."""
