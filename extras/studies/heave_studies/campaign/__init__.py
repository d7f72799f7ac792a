"""Campaigns: many cases of a scenario in worker processes, without ROS."""
