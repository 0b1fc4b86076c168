"""Robots to joint states: read-only adapters, and the contract that they keep."""

from .driver import Driver, DriverError, JointState, Reason, match_joints

__all__ = ["Driver", "DriverError", "JointState", "Reason", "match_joints"]
