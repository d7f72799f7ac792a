"""Scenarios, launching, and the `heave` command."""
