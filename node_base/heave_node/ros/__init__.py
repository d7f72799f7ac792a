"""The ROS shell that every node is made of: the one place of this package that imports rclpy."""
