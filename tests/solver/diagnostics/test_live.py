"""Faults told while a session goes on: by all that its arm may be like, and soon enough."""

from dataclasses import replace

import numpy as np
import pytest
from worlds.sessions import Setting

from mukca.recorder import Sample
from mukca.solver.diagnostics import LiveCheck, RigidModel
from mukca.solver.diagnostics.explain import rounds
from mukca.solver.diagnostics.fault import CLOSE
from mukca.solver.diagnostics.live import SCATTER
from mukca.solver.identification.data import STANDARD_LOAD

LATE = "socket@13+6"


@pytest.fixture(scope="module")
def heavy():
    """An arm of which no figure is known, so that its gears may have any play."""
    return Setting("ur20", 3)


def test_evidence_is_that_over_all_that_an_arm_may_be_like(heavy):
    """With little play and the usual elasticity, a ball of the first 12 was not seated."""
    assert heavy.told(heavy.samples("none")[:12]) == []
    assert heavy.told(heavy.samples("ball@9:5mm")) == ["ball_sample"]


@pytest.mark.parametrize(("slips", "cause"), [([0.6, -0.7, 0.2, -0.3, 0.8], "slips"),
                                              ([0.6] * 5, "zero_lost")])  # fmt: skip
def test_a_joint_that_slips_again_and_again_is_one_fault(slips, cause):
    here = Setting("ur5e", 1)
    samples = here.samples("none")
    q = np.array([sample.position for sample in samples])
    q[6:, 3] += np.deg2rad(np.repeat(slips, 4)[:18])
    samples = tuple(replace(s, position=tuple(row)) for s, row in zip(samples, q, strict=True))
    (fault,) = here.check.faults([here.placement(samples)])
    told = fault.hypothesis
    assert (told.name, told.parameters["joint"]) == (cause, "wrist_1_joint")


def test_each_ball_of_scattered_samples_is_more_probable_than_none():
    """Many that are improbable, each by itself, make none of them probable."""
    here = Setting("panda", 2)
    scene = here.check.scene([here.placement(here.samples("loose")[:17])])
    told = [ball for _, balls in rounds(scene, here.check.of_balls, SCATTER) for ball in balls]
    assert told == []


def test_samples_lie_in_a_socket_that_no_sample_was_said_to_be_in():
    """Nobody has told yet that the ball is in the next socket."""
    here = Setting("panda", 2)
    sound = here.samples("none")
    samples = sound[:6] + sound[12:18] + sound[6:12]
    samples = tuple(replace(s, socket=0, number=i) for i, s in enumerate(samples, 1))
    (fault,) = here.check.faults([here.placement(samples)])
    assert fault.hypothesis.text == "samples 13 to 18 lie in socket 1, not 0"


def test_moments_hold_the_joints_where_their_zeros_were_fitted():
    """Zeros are off by up to 5 degrees; moments tell on which side of its play a joint rests."""
    here = Setting("so101", 0)
    scene = here.check.scene([here.placement(here.samples("none"))])
    true, read = (STANDARD_LOAD.at(arm, scene.q).torques for arm in (here.arm, here.robot))
    fitted = scene.loaded_samples.torques
    off, before = (np.linalg.norm(one - true) for one in (fitted, read))
    assert off < before


class Counting(RigidModel):
    """A model that knows how often it was fitted anew, and by its derivatives alone."""

    def __init__(self, robot):
        super().__init__(robot)
        self.anew = self.by_derivatives = 0

    def fit(self, samples, iterations=40, start=None, linear=None):
        if linear is None:
            self.anew += 1
        else:
            self.by_derivatives += 1
        return super().fit(samples, iterations, start, linear)


def test_few_samples_in_other_sockets_are_looked_at_closely(heavy):
    """So a check takes no longer, whatever happened, with many samples in a placement."""
    check, model = LiveCheck(heavy.robot, 1e-4), Counting(heavy.robot)
    check.__dict__["_model"] = model
    for text, told in ((LATE, "socket"), ("loose", "ball_loose")):
        samples = heavy.samples(text)
        again = [replace(s, number=len(samples) + s.number) for s in heavy.samples("none")]
        longer: tuple[Sample, ...] = (*samples, *again)
        found = check.faults([heavy.placement(longer)])
        assert found and found[0].hypothesis.name == told
    assert model.by_derivatives > 100
    assert model.anew <= 2 * (CLOSE + 4)
