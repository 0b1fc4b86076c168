"""The paper's method (``--method paper``): Eq. (5), which fits the geometry alone."""
