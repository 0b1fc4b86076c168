"""One simulated arm for all tests of this folder."""

import pytest
from calibrated_arm import simulate


@pytest.fixture(scope="session")
def simulated():
    return simulate()
