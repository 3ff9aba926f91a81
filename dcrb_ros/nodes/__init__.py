"""ROS 2 nodes: thin layers over code that runs without ROS."""
