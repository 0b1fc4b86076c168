"""Recordings to a calibrated robot: kinematics, Eq. (5) of the paper, identification."""
