"""What every heave node shares: parameters, tick protocol, lifecycle, diagnostics, topics.

Importing this package does not import rclpy: the modules `parameters`, `constants`, `kinematics`, `randomness` and
`scenario` are
pure, so that components and design tools can use them without ROS.
"""
