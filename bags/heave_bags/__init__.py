"""Recorder, replay, analysis and report of heave-compensation runs.

Importing this package does not import rclpy; recording, playing and substitution do. Reading and analysing need no ROS.
"""
