"""What stands behind ``mukca record``: the session opened, and what guides the operator."""
