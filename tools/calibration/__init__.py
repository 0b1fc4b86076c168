"""The Python face: calibrate, look at the errors, save, load again, validate."""
