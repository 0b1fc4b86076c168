"""The answers to the three questions that a user has after a calibration."""
