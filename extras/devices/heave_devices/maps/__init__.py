"""Maps: which field of a device is which quantity, and how the device is reached."""
