"""The report of a calibration: figures, verdict, answers, plots, one HTML page."""
