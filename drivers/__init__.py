"""Robots to joint states: read-only adapters, and the contract that they keep."""

from .driver import Driver, DriverError, JointState, Reason

__all__ = ["Driver", "DriverError", "JointState", "Reason"]
