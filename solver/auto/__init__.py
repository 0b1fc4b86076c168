"""The default method: geometry and extensions, weighed by evidence (``--method auto``)."""
