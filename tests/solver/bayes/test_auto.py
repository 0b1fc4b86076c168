"""Beyond geometry: what is there is found, what is not vanishes, and outliers hardly count."""

from dataclasses import replace

import numpy as np
import pytest

from mukca.recorder.dataset import Placement
from mukca.solver.bayes.inference import estimate
from mukca.solver.bayes.model import Deflection, extend
from mukca.solver.bayes.model.effects import EFFECTS
from mukca.solver.bayes.results.uncertainty import deviations
from mukca.solver.bayes.selection.model_selection import select_model
from mukca.solver.data import Load, evaluate, measure, observe
from mukca.solver.robot import choose_parameters, load_robot
from mukca.tools.simulation import Imperfection, perturb, reachable_bases, record

pytestmark = pytest.mark.slow

COMPLIANCES = np.array([0.0, 3e-5, 2e-5, 4e-5, 5e-5, 3e-5, 0.0])
"""Of a Panda-like arm [rad/(N m)]."""


class Session:
    """A true arm, and placements recorded with it."""

    def __init__(self, name: str, seed: int, count: int, how: Imperfection) -> None:
        self.robot = load_robot(name)
        self.generator = np.random.default_rng(seed)
        self.arm = perturb(self.robot, self.generator, 2e-3, 5e-3)
        bases = reachable_bases(self.arm, self.generator, count)
        self.placements = [
            record(self.arm, base, self.generator, imperfection=how) for base in bases
        ]
        self.parameters = choose_parameters(self.robot)

    def observe(self, placements: list[Placement]):
        return observe([measure(p, self.robot) for p in placements], self.robot)

    def error(self, found, placement: Placement) -> float:
        measured = measure(placement, self.robot)
        torques = Load().torques(self.robot, measured)
        return evaluate(found.predict(measured.positions, torques), measured).mean_absolute_error


@pytest.mark.parametrize("name", ["panda", "gen3_lite"])
def test_what_is_not_there_vanishes(name: str) -> None:
    session = Session(name, 1, 2, Imperfection(noise=1e-4))
    fit = select_model(session.robot, session.parameters, session.observe(session.placements[:1]))
    held_out = session.placements[1]
    assert session.error(fit.full, held_out) < 1.02 * session.error(fit.geometric, held_out)
    assert fit.full.model.extensions == ()
    data = fit.full.data
    slopes = fit.full.model.ball.linearise(fit.full.values, data.positions).by_joints
    noise = np.trace(fit.full.noise.scales(slopes), axis1=1, axis2=2).mean() / 3
    assert noise**0.5 == pytest.approx(1e-4, rel=0.25)


def test_compliance_is_found_within_its_intervals() -> None:
    how = Imperfection(noise=5e-5, deflection=Deflection(("compliance",), (COMPLIANCES,)))
    session = Session("panda", 2, 2, how)
    fit = select_model(session.robot, session.parameters, session.observe(session.placements[:1]))
    assert "compliance" in fit.full.model.extensions
    n = fit.full.model.geometry
    found, deviation = fit.full.x[n : n + 7], deviations(fit.full)[n : n + 7]
    assert np.all(found >= 0)
    loaded = [1, 2, 3]  # the joints that carry the arm
    assert found[loaded] == pytest.approx(
        COMPLIANCES[loaded], abs=float(3 * deviation[loaded].max())
    )
    held_out = session.placements[1]
    assert session.error(fit.full, held_out) < 0.9 * session.error(fit.geometric, held_out)


def test_tilt_is_found_within_its_intervals() -> None:
    tilts = np.array([25e-6, 20e-6, 16e-6, 15e-6, 0, 0, 0, 15e-6, 5e-6, 21e-6, 10e-6, 0, 0, 0])
    how = Imperfection(noise=5e-5, deflection=Deflection(("tilt",), (tilts,)))
    session = Session("panda", 2, 2, how)
    fit = select_model(session.robot, session.parameters, session.observe(session.placements[:1]))
    assert "tilt" in fit.full.model.extensions
    names = fit.full.model.names
    own = [
        names.index(name) for name in EFFECTS["tilt"].coefficient_names(session.robot.joint_names)
    ]
    found, deviation = fit.full.x[own], deviations(fit.full)[own]
    assert np.all(found >= 0)
    assert np.abs(found - tilts)[deviation > 0] == pytest.approx(0, abs=float(3 * deviation.max()))
    held_out = session.placements[1]
    assert session.error(fit.full, held_out) < 0.9 * session.error(fit.geometric, held_out)


def test_transmission_error_is_found() -> None:
    generator = np.random.default_rng(0)
    waves = tuple(generator.normal(0, 4e-4, 14) for _ in range(2))
    how = Imperfection(noise=5e-5, deflection=Deflection(("harmonic_1", "harmonic_2"), waves))
    session = Session("panda", 3, 3, how)
    fit = select_model(session.robot, session.parameters, session.observe(session.placements[:2]))
    assert "harmonic_2" in fit.full.model.extensions
    held_out = session.placements[2]
    assert session.error(fit.full, held_out) < 0.7 * session.error(fit.geometric, held_out)


def test_backlash_is_taken_for_noise_of_the_joints() -> None:
    session = Session("gen3_lite", 4, 1, Imperfection(noise=1e-4, backlash=3e-3))
    data = session.observe(session.placements)
    found = estimate(extend(session.robot, session.parameters), data)
    assert 0.9e-3 < found.noise.joint < 1.8e-3  # each joint is 1.5 mrad off, to either side
    in_space = estimate(extend(session.robot, session.parameters), data, joint_noise=False)
    assert in_space.noise.joint == 0
    assert found.log_evidence > in_space.log_evidence + 3


def test_measured_effort_beats_gravity_torque_under_a_hand() -> None:
    """A hand that pushes bends the joints; only measured efforts know how."""
    how = Imperfection(
        noise=5e-5, hand=20.0, deflection=Deflection(("compliance",), (3 * COMPLIANCES,))
    )
    session = Session("panda", 5, 2, how)
    train, held_out = session.placements
    bare = [
        replace(p, samples=tuple(replace(s, effort=None) for s in p.samples))
        for p in session.placements
    ]
    by_effort = select_model(session.robot, session.parameters, session.observe([train])).full
    by_gravity = select_model(session.robot, session.parameters, session.observe([bare[0]])).full
    assert session.error(by_effort, held_out) < 0.7 * session.error(by_gravity, bare[1])


@pytest.mark.parametrize("name", ["panda", "iiwa14"])
def test_gross_outliers_hardly_count(name: str) -> None:
    session = Session(name, 1, 3, Imperfection(noise=1e-4))
    generator = np.random.default_rng(9)
    spoilt = [_with_outliers(session, p, generator) for p in session.placements[:2]]
    held_out = session.placements[2]
    clean = select_model(
        session.robot, session.parameters, session.observe(session.placements[:2])
    ).full
    robust = select_model(session.robot, session.parameters, session.observe(spoilt)).full
    assert session.error(robust, held_out) < 1.15 * session.error(clean, held_out)
    assert np.sort(robust.weights)[:10].max() < 0.06


def _with_outliers(session: Session, placement: Placement, generator) -> Placement:
    """Move a tenth of the samples' balls by 5 to 50 mm, by turning one joint."""
    samples = list(placement.samples)
    for i in range(0, len(samples), 10):
        q = np.array(samples[i].position)
        q[generator.integers(1, 4)] += generator.choice([-1, 1]) * generator.uniform(0.02, 0.1)
        samples[i] = replace(samples[i], position=tuple(q.tolist()))
    return replace(placement, samples=tuple(samples))


def test_leaving_one_out_drops_what_does_not_help() -> None:
    session = Session("ur5e", 7, 3, Imperfection(noise=1e-4))
    fit = select_model(session.robot, session.parameters, session.observe(session.placements))
    assert [note.split(":")[0] for note in fit.notes] == ["compliance", "tilt", "transmission"]
    assert fit.full.model.extensions == ()


def test_a_model_does_not_shrink_to_look_better() -> None:
    """Errors shrink with the model; over many samples that would outweigh the base."""
    robot = load_robot("panda")
    generator = np.random.default_rng(0)
    bases = reachable_bases(robot, generator, 3)
    placements = [record(robot, b, generator, samples=60, noise=1e-4) for b in bases]
    data = observe([measure(p, robot) for p in placements], robot, deviation=1e-4)
    model = extend(robot, choose_parameters(robot))
    scale = model.by_scale() @ estimate(model, data).x
    assert abs(scale) < 3e-4  # without the volume: -2e-3


def test_stages_can_be_switched_off() -> None:
    how = Imperfection(noise=5e-5, deflection=Deflection(("compliance",), (COMPLIANCES,)))
    session = Session("panda", 2, 1, how)
    data = session.observe(session.placements)
    fit = select_model(session.robot, session.parameters, data, stages=(), joint_noise=False)
    assert fit.notes == () and fit.full.model.extensions == ()
    assert fit.full.noise.joint == 0
