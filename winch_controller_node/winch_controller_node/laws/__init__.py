"""Control laws: from the estimated state to one winch command per tick. No ROS, no clock, no randomness."""
