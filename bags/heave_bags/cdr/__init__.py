"""CDR: the layout of serialised ROS 2 messages, their columns, and equal bytes for equal messages."""
