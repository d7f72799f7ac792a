"""What nodes say to one another: topics, codes, sensors, faults, and the readings in messages."""
