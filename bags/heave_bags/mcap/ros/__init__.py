"""What ROS puts into a bag: definitions of messages, quality of service."""
