"""The plant: cable, subsea unit, seabed, current, the virtual winch, and the sensors on them.

Importing this package imports nothing else; every module but the `node` modules is pure (no ROS).
"""
