"""Blocks to ROS messages and back, as pure functions. No other package depends on the fields of messages."""
