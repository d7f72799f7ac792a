"""The subcommands of `heave`, one module each: its arguments, its help and example, and `execute`.

A module imports what is heavy (ROS, the models, plots) inside `execute`, so that `heave --help` waits for none of it.
To add a command: one module as `command.CommandModule` says, and its name in `heave_bringup.parser`.
"""
