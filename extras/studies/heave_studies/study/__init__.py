"""Studies: many cases of a scenario, run and judged without ROS, from a file to one table and one page."""
