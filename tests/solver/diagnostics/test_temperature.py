"""An explanation by a clock, as anyone may add one: what it sees of samples, and what it costs."""

from dataclasses import replace

import numpy as np
import pytest

from mukca.recorder import Placement, Sample
from mukca.solver.diagnostics import RigidModel
from mukca.solver.diagnostics.hypotheses import KINDS, Comparison, kind_of
from mukca.solver.diagnostics.hypotheses.kinds import Block
from mukca.solver.diagnostics.scene_fit import Given, scene_of
from mukca.solver.identification.data import Measurement
from mukca.solver.identification.robot import BallModel, workspace

RISE = 5.0
"""Rise of temperature that is worth a word [K]."""


def warmed(scene):
    """Return blocks of placements during which the column warmed, and took the ball along."""
    for place, rows in enumerate(scene.places):
        warmth = scene.loaded_samples.temperature[rows, 0]
        if np.ptp(warmth) > RISE:
            columns = ((warmth - warmth.mean()) / np.ptp(warmth))[:, None, None] * np.eye(3)
            names = [{**scene.named(place), "rise": float(np.ptp(warmth))}]
            yield Block(scene.rows(rows), columns.reshape(1, -1, 3), names, (1e-3, 1e-2))


WARMED = replace(
    kind_of("drift", warmed),
    name="warmed",
    form="{placement} warmed by {rise:.1f} K, and the ball moved with it",
    of_points={},
    prior=0.02,
)


@pytest.fixture
def scene(panda, true_panda):
    """Return points of an instrument, by what moved the balls: a factor on the warmth [m/K]."""

    def scene(by_warmth, *, rise=8.0):
        generator = np.random.default_rng(5)
        q = workspace(panda, 50)
        # it warms, and cools again, so that a drift in time explains it less well
        warmth = rise * np.sin(np.linspace(0, np.pi, 50))
        balls = BallModel(true_panda, ()).points(np.zeros(0), q) + generator.normal(
            0, 1e-4, (50, 3)
        )
        balls[:, 2] += by_warmth * warmth
        rows = zip(q.tolist(), balls.tolist(), (20 + warmth).tolist(), strict=True)
        samples = tuple(Sample(tuple(a), 0, point=tuple(b), temperature=t) for a, b, t in rows)
        placement = Placement(name="front", samples=samples, joint_names=panda.joint_names)
        model, measured = RigidModel(panda), [Measurement(placement, 0.0)]
        return scene_of(model, measured, Given(), 1e-4, [0.0])

    return scene


def likeliest(scene):
    candidates = Comparison(scene, (*KINDS, WARMED)).candidates
    return max(candidates, key=lambda candidate: candidate.log_evidence)


def test_a_ball_that_moves_with_the_temperature_is_explained_by_it(scene):
    found = likeliest(scene(2e-4))
    assert found.kind.name == "warmed"
    assert found.parameters["rise"] == pytest.approx(8.0, abs=0.1)
    assert found.parameters["size"] == pytest.approx(1.6e-3, rel=0.2)
    assert "front warmed by 8.0 K" in found.hypothesis().text


def test_warmth_that_moves_nothing_explains_nothing(scene):
    assert likeliest(scene(0.0)).kind.name == "sound"
    assert likeliest(scene(2e-4, rise=4.0)).kind.name != "warmed"
