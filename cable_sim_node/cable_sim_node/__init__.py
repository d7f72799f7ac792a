"""The plant: cable, subsea unit, seabed, current, the virtual winch, and the sensors on them. Importing it imports nothing."""
