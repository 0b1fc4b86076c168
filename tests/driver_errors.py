"""Reasons for which a driver refuses, and all states until it is silent."""

from contextlib import contextmanager

import pytest

from mukca import MukcaError


@contextmanager
def refused(reason, match=None):
    """Within it a driver must refuse for this reason, as in ``refused("BUSY")``."""
    with pytest.raises(MukcaError, match=match) as caught:
        yield caught
    assert reason_of(caught.value) == reason, caught.value


def reason_of(error):
    """Return the name of a driver error's reason."""
    reason = vars(error)["reason"]
    return reason.name


def read_until_silent(driver, timeout=0.2):
    """Return all states up to the first silence."""
    states = []
    try:
        while True:
            states.append(driver.read(timeout))
    except MukcaError as error:
        assert reason_of(error) == "SILENT", error
    return states
