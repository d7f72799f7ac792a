"""Sea state to boom-tip motion, and what the motion reference unit says of it.

Importing this package imports nothing else; every module but `node` is pure (no ROS).
"""
