"""Operating a run that is under way: what an operator requests, what is known of the run, the screen and its keys.

`tasks` and `moves` say what is requested and when it is done; `link` and its `calls` alone speak ROS.
"""
