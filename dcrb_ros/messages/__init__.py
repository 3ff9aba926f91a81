"""Blocks to ROS messages and back, as pure functions: the only package that knows the fields of messages."""
