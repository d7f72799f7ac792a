"""What laws are made of: effort, limits, governor, the state of the loop that they are given."""
