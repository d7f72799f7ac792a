"""What winch, cable, sensors and sea really are: the adviser."""
