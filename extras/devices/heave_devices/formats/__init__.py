"""The formats of lines and datagrams: what reads each, with units and signs by published documents."""
