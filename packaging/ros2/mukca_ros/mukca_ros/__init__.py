"""A calibrated arm in ROS 2."""
