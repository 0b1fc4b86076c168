"""Numbers that are given as arrays."""

import numpy as np

from .recording_error import RecordingError


def numbers_of(values: object, what: str) -> np.ndarray:
    """Return values as an array of finite numbers.

    Raises:
        RecordingError: One of the values, which is called ``what``, is no number.
    """
    try:
        numbers = np.array(values)
        if np.iscomplexobj(numbers):
            raise TypeError("they are complex")
        numbers = numbers.astype(float)
    except (TypeError, ValueError) as error:
        raise RecordingError(f"{what}: real numbers are expected: {error}") from None
    places = np.argwhere(~np.isfinite(np.atleast_1d(numbers)))
    if len(places):
        value = np.atleast_1d(numbers)[tuple(places[0])]
        raise RecordingError(f"{what}{places[0].tolist()}: {value:g} is no number")
    return numbers
