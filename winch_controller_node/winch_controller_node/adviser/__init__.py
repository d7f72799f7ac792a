"""What winch, cable, sensors and sea really are: identified from what was ordered and read, in a process of its own."""
