"""Recorder, replay, analysis and report of heave-compensation runs.

Importing this package does not import rclpy; only `recorder_node` and `player_node` do. `kpi` needs numpy alone.
"""
