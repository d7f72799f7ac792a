"""One lift, from plan to as-built: limits of each phase, a forecast held against them, and the bag judged by phase."""
