"""What is watched beside the modes: the winch against its belief, the load, what is demanded of the winch."""
