"""The report of a calibration: :mod:`figures` works out the numbers, :mod:`page` shows them."""
