"""The paper's method: Eq. (5), geometry alone (``--method paper``)."""
