"""Sessions as ROS 2 messages."""
