"""What a calibration is written as for other programs: one module a format."""
