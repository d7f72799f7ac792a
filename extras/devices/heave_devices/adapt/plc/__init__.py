"""PLCs that are asked for their values: Modbus/TCP and OPC UA."""
