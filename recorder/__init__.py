"""Joint states to recordings: the session at the robot, and the files it writes."""
