"""What every heave node shares: parameters, tick protocol, lifecycle, diagnostics, topics.

Importing this package does not import rclpy. Everything but the wing `ros` is pure, so that components and design tools
can use it without ROS.
"""
