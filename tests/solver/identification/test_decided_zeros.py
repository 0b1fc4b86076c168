"""Zeros that the data decide: one rule for what is said and for what is written."""

from types import SimpleNamespace

import numpy as np
import pytest

from mukca.solver.identification.selection import joint_offsets_in_words
from mukca.tools.export.zeros import JointZero


@pytest.mark.parametrize(
    ("zero", "deviation", "decided"),
    [(3.05, 0.83, True), (0.1, 0.19, True), (0.5, 0.3, False), (-0.7, 0.3, True)],
)
def test_what_is_not_decided_is_not_written(zero, deviation, decided):
    zero, deviation = np.radians([zero, deviation]).tolist()
    model = SimpleNamespace(robot=SimpleNamespace(joint_names=["lift"]), geometry=0)
    covariance = np.array([[deviation**2]])
    posterior = SimpleNamespace(model=model, x=np.array([zero]), covariance=covariance)
    said = joint_offsets_in_words(posterior)
    assert ("not decided" not in said) is JointZero("lift", zero, deviation).decided is decided
