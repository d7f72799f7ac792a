"""Logs of devices and ships as records and bags."""
