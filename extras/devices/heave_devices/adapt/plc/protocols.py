"""The protocol of a PLC, with its library, which is loaded where a map names it."""

from __future__ import annotations

from heave_bringup.errors import CommandError
from heave_node.extras import how_to_install

from heave_devices.adapt.plc.polled import Exchange
from heave_devices.maps.device_map import DeviceMap


def exchange_of(device: DeviceMap) -> Exchange:
    """Return what asks the PLC of a `device` for the fields of its map, and sends it the orders.

    Raises CommandError where the library of its protocol is not installed.
    """
    link, command = device.link, device.command
    assert link is not None
    names = [name for channel in device.channels.values() for name in (channel.field, channel.valid) if name]
    fields = [device.bit_of(name)[0] for name in names]
    orders = [device.bit_of(order.path)[0] for order in command.orders] if command is not None else []
    try:
        if link.kind == "modbus":
            from heave_devices.adapt.plc.modbus import ModbusExchange  # noqa: PLC0415 - its library may be missing

            return ModbusExchange(link, fields, orders)
        from heave_devices.adapt.plc.opcua import OpcUaExchange  # noqa: PLC0415 - an extra

        return OpcUaExchange(link, fields, orders)
    except ImportError as error:
        how = how_to_install("opcua") if link.kind == "opcua" else "pip install 'pymodbus>=3.10'"
        raise CommandError(f"{device.name}: {link.kind} needs the package {error.name}; {how}") from None
