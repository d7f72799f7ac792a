"""Operating a run that is under way: what an operator requests, what is known of the run, the screen and its keys.

`tasks` says what is requested and when it is done; `link` is the one place that speaks ROS.
"""
