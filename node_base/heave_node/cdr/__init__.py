"""CDR: serialised ROS 2 messages, packed and unpacked by the layouts that their definitions give. No rclpy."""
