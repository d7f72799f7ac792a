"""Errors that the `heave` command tells its user in one line."""


class CommandError(Exception):
    """The command could not do what it says; the message is one line."""


class NoRunError(CommandError):
    """There is no run to operate."""
