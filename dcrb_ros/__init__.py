"""A simulated double-row cylindrical roller bearing for condition monitoring, as a ROS 2 package."""

__version__ = "0.1.0"
