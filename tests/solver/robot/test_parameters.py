"""Choosing what is free."""

import pytest

from mukca import MukcaError
from mukca.solver.robot import choose_parameters


def names(panda, **words):
    return [p.name for p in choose_parameters(panda, **words)]


def test_the_default_is_every_moving_joint_and_the_ball(panda):
    chosen = choose_parameters(panda)
    assert len(chosen) == 48
    assert {p.joint for p in chosen} == {*panda.joint_names, "ball_joint"}
    assert [p.of_ball for p in chosen] == [False] * 42 + [True] * 6


def test_words_name_joints_groups_components_and_patterns(panda):
    assert names(panda, free=["ball_joint.xyz"]) == ["ball_joint.x", "ball_joint.y", "ball_joint.z"]
    assert names(panda, free=["panda_joint8"])[0] == "panda_joint8.x"
    assert len(names(panda, free=["panda_joint?.yaw"])) == 8
    assert len(names(panda, fix=["*.rpy"])) == 24
    assert len(names(panda, fix=["panda_joint1", "ball_joint.roll"])) == 41


@pytest.mark.parametrize("word", ["panda_joint9", "panda_joint1.w", "", "joint1.x"])
def test_unknown_words_are_told(panda, word):
    with pytest.raises(MukcaError, match="panda_joint1"):
        choose_parameters(panda, fix=[word])


def test_something_must_be_free(panda):
    with pytest.raises(MukcaError, match="nothing is left free"):
        choose_parameters(panda, fix=["*"])
