"""The command line, which needs no ROS."""
