"""A hand on an arm that holds itself is told from measured efforts, and only from those."""

from mukca.recorder.stream import ContactDetector, JointLimits, StationaryPose

JOINTS = (JointLimits("shoulder"), JointLimits("elbow"))
QUIET = (0.02, 0.02)


def rest(effort, spread=QUIET):
    return StationaryPose((0.1, 0.2), (1e-5, 1e-5), effort, spread, 1.0, 300)


def test_tremor_is_told_against_the_quietest_rest():
    push = ContactDetector(JOINTS)
    assert push.evidence(rest((1.0, 1.0), (0.5, 0.5))) is None  # nothing to compare with yet
    assert push.evidence(rest((1.0, 1.0), QUIET)) is None
    assert "the effort of shoulder trembles by 0.50 N m" in str(
        push.evidence(rest((1.0, 1.0), (0.5, 0.5)))
    )
    assert push.evidence(rest((1.0, 1.0), (0.09, 0.02))) is None  # as small as sensors' noise
    assert push.evidence(rest((1.0, 1.0), QUIET)) is None
