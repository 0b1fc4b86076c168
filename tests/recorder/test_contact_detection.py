"""A hand on an arm that holds itself is told from measured efforts, and only from those."""

import pytest

from mukca.recorder.stream import ContactDetector, JointLimits, StationaryPose

JOINTS = (JointLimits("shoulder"), JointLimits("elbow"))
QUIET = (0.02, 0.02)


def rest(effort, spread=QUIET):
    return StationaryPose((0.1, 0.2), (1e-5, 1e-5), effort, spread, 1.0, 300)


@pytest.mark.parametrize(
    ("effort", "told"),
    [
        ((40.0, 5.0), None),
        ((45.9, 5.0), None),
        ((46.1, 5.0), "shoulder exerts +6.1 N m beyond gravity"),
        ((40.0, 2.4), "elbow exerts -2.6 N m"),
    ],
)
def test_a_load_beyond_gravity_is_told(effort, told):
    said = ContactDetector(JOINTS, lambda q: (40.0, 5.0)).evidence(rest(effort))
    assert said is None if told is None else told in str(said)


def test_tremor_is_told_against_the_quietest_rest():
    push = ContactDetector(JOINTS)
    assert push.evidence(rest((1.0, 1.0), (0.5, 0.5))) is None  # nothing to compare with yet
    assert push.evidence(rest((1.0, 1.0), QUIET)) is None
    assert "the effort of shoulder trembles by 0.50 N m" in str(
        push.evidence(rest((1.0, 1.0), (0.5, 0.5)))
    )
    assert push.evidence(rest((1.0, 1.0), (0.09, 0.02))) is None  # as small as sensors' noise
    assert push.evidence(rest((1.0, 1.0), QUIET)) is None


def test_without_efforts_nothing_is_claimed():
    assert ContactDetector(JOINTS, lambda q: (40.0, 5.0)).evidence(rest(None, None)) is None


def test_without_masses_no_load_is_claimed():
    assert ContactDetector(JOINTS).evidence(rest((1000.0, 0.0))) is None
