"""The tick protocol without ROS: ticks, what a node still lacks, who takes part, how old the loop is."""
