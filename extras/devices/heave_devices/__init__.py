"""Devices of others as they speak: lines, datagrams and messages to quantities in SI units and the suite's signs."""
