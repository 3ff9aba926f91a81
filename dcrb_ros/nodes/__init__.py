"""The ROS 2 nodes: thin wires round what works without ROS."""
