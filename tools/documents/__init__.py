"""The files that a calibration leaves behind, typed: ``calibration.json`` and ``report.json``."""
