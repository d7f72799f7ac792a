"""An open benchmark of heave compensation: anyone's controller on the same problems, judged by the same rules. No ROS.

`interface` is all that an entrant needs to know; README.md says how to enter.
"""
