"""Reasons for which a driver refuses, and all states until it is silent."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from mukca import Driver, JointState, MukcaError


@contextmanager
def refused(reason: str, match: str | None = None) -> Iterator[Any]:
    """Within it a driver must refuse for this reason, as in ``refused("BUSY")``."""
    with pytest.raises(MukcaError, match=match) as caught:
        yield caught
    assert reason_of(caught.value) == reason, caught.value


def reason_of(error: MukcaError) -> str:
    """Return the name of a driver error's reason."""
    reason: Any = vars(error)["reason"]
    return reason.name


def read_until_silent(driver: Driver, timeout: float = 0.2) -> list[JointState]:
    """Return all states up to the first silence."""
    states: list[JointState] = []
    try:
        while True:
            states.append(driver.read(timeout))
    except MukcaError as error:
        assert reason_of(error) == "SILENT", error
    return states
