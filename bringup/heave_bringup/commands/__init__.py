"""The subcommands of `heave`, one module each with one function: `execute(options)`.

They are imported when their command is given: `heave --help` does not wait for ROS, the plant or the plots.
"""
