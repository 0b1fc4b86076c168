"""Robots to joint states: drivers that only read, and the contract that they keep."""

from .driver import Driver, DriverError, JointState, Reason, match_joints

__all__ = ["Driver", "DriverError", "JointState", "Reason", "match_joints"]
