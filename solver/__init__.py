"""From recordings to a calibrated robot: what a robot is, what was measured, and two methods."""
