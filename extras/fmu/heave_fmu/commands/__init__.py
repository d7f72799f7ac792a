"""Subcommands of `heave`."""
