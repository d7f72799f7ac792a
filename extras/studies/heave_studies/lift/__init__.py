"""A lift by phases: a forecast held against the limits of each, and the bag of the lift judged by phase."""
