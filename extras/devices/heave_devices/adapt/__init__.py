"""Devices of others in a run: serial lines, datagrams and topics of any type, by a map."""
