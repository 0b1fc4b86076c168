"""The session as a value: counts, undo, sockets, and what it refuses to capture."""

import math

import pytest
from cases import by_table
from hypothesis import given
from hypothesis import strategies as st

from mukca.recorder import Sample
from mukca.recorder.session import Session
from mukca.recorder.stream import JointLimits

JOINTS = (JointLimits("shoulder", -1.0, 1.0), JointLimits("rail", 0.0, 0.5, prismatic=True))


def captured(session, *position):
    return session.captured(Sample(position, session.socket, number=session.next_number))


@pytest.mark.slow
@given(st.lists(st.sampled_from("a01u"), max_size=30))
def test_counts_are_those_of_a_list_per_socket(keys):
    session = Session(JOINTS)
    model = []
    for key in keys:
        if key == "a":
            session = captured(session, 0.0, 0.0)
            model.append(session.socket)
        elif key == "u":
            session = session.without(session.last.number) if session.last else session
            model = model[:-1]
        else:
            session = session.switched(int(key))
        assert session.counts == (model.count(0), model.count(1))
        assert [s.socket for s in session.live] == model
    assert [s.number for s in session.samples] == list(range(1, keys.count("a") + 1))


@by_table("degrees", "rail", "told")
def test_what_is_refused_at_the_same_socket(degrees, rail, told):
    refusal = captured(Session(JOINTS), 0.0, 0.0).refusal((math.radians(degrees), rail))
    assert refusal is None if told is None else told in str(refusal)


@pytest.mark.parametrize(("elbow", "asks"), [(-1.0, True), (3.1, False)])
def test_of_a_joint_whose_mirrored_reading_is_within_limits_the_sign_is_asked(elbow, asks):
    refusal = Session((JointLimits("elbow", -0.2, 2.9),)).refusal((elbow,))
    assert ("the right robot model and sign?" in str(refusal)) == asks and "elbow" in str(refusal)


def test_the_next_socket_is_one_that_lacks_samples():
    session = Session(JOINTS, sockets=3, target=1)
    assert session.next_socket == 1 and not session.complete
    session = captured(session.switched(1), 0.1, 0.1).switched(0)
    assert session.next_socket == 2
    session = captured(captured(session, 0.2, 0.1).switched(2), 0.3, 0.1)
    assert session.complete
