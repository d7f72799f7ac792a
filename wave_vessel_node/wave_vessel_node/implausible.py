"""How a user accepts the figures of a file that are implausible."""

ACCEPT = "--set system.accept_implausible=true"
"""Option that takes them as they are; see `heave_node.files.plausible`."""
