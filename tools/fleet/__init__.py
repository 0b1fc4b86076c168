"""Many arms at once: one folder an arm, each calibrated by its own recordings."""
