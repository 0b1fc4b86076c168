"""Beyond geometry: what is there is found, what is not vanishes, and outliers hardly count."""

from dataclasses import replace

import numpy as np
import pytest
from altered import coefficients, moved, with_efforts
from imagined import held_out

import mukca
from mukca.solver.identification import effects

pytestmark = pytest.mark.slow
EXTENSIONS = tuple(
    extension
    for extension, names in effects.EXTENSIONS.items()
    if not any(effects.EFFECTS[name].requires for name in names)
)
"""Those that are tried without --zeros."""


def all_but(*tried):
    """Options of a calibration that tries these effects alone."""
    return {"without": tuple(name for name in EXTENSIONS if name not in tried)}


def test_what_is_not_there_vanishes():
    robot = mukca.load_robot("gen3_lite")
    _, (train, test) = mukca.simulate_recordings(robot, 2, seed=1, samples=20, noise=1e-4)
    found = mukca.calibrate(robot, train, test=test)
    geometric = mukca.calibrate(robot, train, test=test, without=EXTENSIONS)
    assert found.document.deflection == {} and found.calibrated.exported is None
    assert held_out(found) < 1.02 * held_out(geometric)
    noise = found.document.noise
    assert 0.5e-4 < noise.space < 1.3e-4


def test_elasticity_is_found_within_its_intervals(panda):
    sizes = {"compliance": 8e-5, "tilt": 5e-5}
    truth, (train, test) = mukca.simulate_recordings(panda, 2, seed=2, samples=20, **sizes)
    options = all_but("compliance", "tilt")
    found = mukca.calibrate(panda, train, test=test, **options)
    geometric = mukca.calibrate(panda, train, test=test, without=EXTENSIONS)
    for kind, true in zip(sizes, truth.deflection.coefficients, strict=True):
        assert any(line.startswith(f"{kind}: kept") for line in found.document.choices or ())
        values, deviations = coefficients(found, kind)
        assert (values >= 0).all()
        assert (np.abs(values - true) < 3 * deviations.clip(min=1e-7)).mean() > 0.9
    assert held_out(found) < 0.9 * held_out(geometric)
    assert {c.unit for c in found.document.coefficients or ()} >= {"rad/(N m)"}


def test_transmission_error_is_found(panda):
    _, (train, test) = mukca.simulate_recordings(panda, 2, seed=3, samples=20, transmission=4e-4)
    found = mukca.calibrate(panda, train, test=test, **all_but("transmission"))
    assert {"harmonic_1", "harmonic_2"} <= found.document.deflection.keys()
    geometric = mukca.calibrate(panda, train, test=test, without=EXTENSIONS)
    assert held_out(found) < 0.7 * held_out(geometric)


def test_noise_of_the_joints_is_told_from_noise_in_space():
    """Each joint is 1.5 mrad off, to either side, as by backlash."""
    robot = mukca.load_robot("gen3_lite")
    _, (train,) = mukca.simulate_recordings(robot, 1, seed=4, noise=1e-4)
    sides = np.random.default_rng(0).choice([-1.5e-3, 1.5e-3], train.positions.shape)
    spoilt = moved(train, train.positions + sides)
    found = mukca.calibrate(robot, spoilt, without=EXTENSIONS).document
    in_space = mukca.calibrate(robot, spoilt, without=(*EXTENSIONS, "joint-noise")).document
    assert 0.9e-3 < found.noise.joint < 1.8e-3
    assert in_space.noise.joint == 0
    assert (found.log_evidence or 0) > (in_space.log_evidence or 0) + 3


def test_measured_efforts_tell_how_an_arm_bends(panda):
    """Efforts unlike gravity's, as under a hand that pushes, and readings bent by them."""
    _, (train, test) = mukca.simulate_recordings(panda, 2, seed=5)
    compliance, generator = np.array([0, 9, 6, 12, 15, 9, 0]) * 1e-5, np.random.default_rng(0)

    def pushed(placement):
        efforts = generator.normal(0, 10, placement.positions.shape)
        bent = moved(placement, placement.positions + compliance * efforts)
        return with_efforts(bent, efforts)

    options = all_but("compliance")
    by_effort = mukca.calibrate(panda, pushed(train), test=pushed(test), **options)
    assert held_out(by_effort) < 3e-4
    found, _ = coefficients(by_effort, "compliance")
    assert found[1:6] == pytest.approx(compliance[1:6], abs=1.5e-5)


def test_gross_outliers_hardly_count():
    """A tenth of the balls, 5 to 50 mm off."""
    robot, generator = mukca.load_robot("panda"), np.random.default_rng(9)
    _, (*train, test) = mukca.simulate_recordings(robot, 3, samples=15, seed=1, noise=1e-4)
    spoilt = []
    for placement in train:
        q = placement.positions.copy()
        turns = generator.choice([-1, 1], 3) * generator.uniform(0.02, 0.1, 3)
        q[np.arange(0, 30, 10), generator.integers(1, 4, 3)] += turns
        spoilt.append(moved(placement, q))
    clean, robust = (
        mukca.calibrate(robot, data, test=test, without=EXTENSIONS, as_recorded=True)
        for data in (train, spoilt)
    )
    assert held_out(robust) < 1.15 * held_out(clean)
    weights = [s.weight for p in robust.document.data for s in p.samples if s.weight is not None]
    assert np.sort(weights)[:6].max() < 0.06
    assert robust.document.noise.nu < clean.document.noise.nu


def test_leaving_one_out_drops_what_does_not_help():
    robot = mukca.load_robot("ur5e")
    _, train = mukca.simulate_recordings(robot, 3, seed=7, noise=1e-4)
    found = mukca.calibrate(robot, train)
    assert [note.split(":")[0] for note in found.document.choices or ()] == list(EXTENSIONS)
    assert found.document.deflection == {}


def test_of_many_placements_some_are_left_out_at_a_time():
    robot = mukca.load_robot("ur5e")
    _, train = mukca.simulate_recordings(robot, 6, samples=8, seed=3, compliance=3e-4)
    tried = []
    found = mukca.calibrate(robot, train, progress=tried.append, **all_but("compliance"))
    assert "compliance" in tried and "compliance" in found.document.deflection
    (line,) = found.document.choices or ()
    assert "where one placement is left out, all together lower errors by" in line


def test_a_model_does_not_shrink_to_look_better(panda):
    """Errors shrink with the model; over many samples that would outweigh the base."""
    _, train = mukca.simulate_recordings(
        panda, 3, samples=60, seed=0, noise=1e-4, translation=0, rotation=0
    )
    found = mukca.calibrate(panda, train, distance_deviation=1e-4, without=EXTENSIONS)
    assert abs(found.document.scale.value) < 3e-4  # without the volume: -2e-3


def test_thousands_of_samples_do_not_blow_the_robot_up(panda):
    """And no width follows unknowns that are far astray: it would be 100 rad for good."""
    _, (train,) = mukca.simulate_recordings(panda, 1, samples=60, seed=3, noise=1e-4)
    shifts = np.random.default_rng(0).normal(0, 1e-5, (18, *train.positions.shape))
    often = [moved(train, train.positions + shift).samples for shift in shifts]
    many = replace(train, samples=tuple(sample for samples in often for sample in samples))
    found, few = (mukca.calibrate(panda, p, without=EXTENSIONS).document for p in (many, train))
    assert found.noise.space == pytest.approx(few.noise.space, rel=0.1)
    assert abs(found.scale.value - few.scale.value) < 2e-3
    assert max(group.width for group in found.groups) <= 0.1


@pytest.mark.parametrize("seed", [7, 10])
def test_no_variance_is_negative_where_a_width_collapses(seed):
    """Five samples a socket of a gear with 5 mrad of noise."""
    robot = mukca.load_robot("gen3_lite")
    _, (train,) = mukca.simulate_recordings(robot, 1, samples=5, seed=seed, noise=1e-4)
    noise = np.random.default_rng(seed).normal(0, 5e-3, train.positions.shape)
    found = mukca.calibrate(robot, moved(train, train.positions + noise)).document
    deviations = [p.standard_deviation for p in found.parameters]
    assert all(d is not None and np.isfinite(d) and d >= 0 for d in deviations)
    assert found.uncertainty is not None
    assert np.isfinite(found.uncertainty.distance_deviation.worst)


def test_stated_deviations_come_true(panda):
    """Of all parameters, also those that only the prior holds."""
    truth, train = mukca.simulate_recordings(panda, 2, samples=20, seed=1, noise=1e-4)
    found = mukca.calibrate(panda, train, without=EXTENSIONS)
    assert [p.name for p in truth.parameters] == [p.name for p in found.document.parameters]
    stated = np.array([p.standard_deviation for p in found.document.parameters], dtype=float)
    off = np.abs(found.calibrated.values - truth.values)
    kept = [not p.of_ball for p in truth.parameters]  # its orientation means nothing
    ratios = (off / stated)[kept]
    assert np.mean(ratios < 2) > 0.9
    assert 0.4 < np.mean(ratios**2) ** 0.5 < 1.6


def test_more_samples_tell_more(panda):
    _, (one, other, test) = mukca.simulate_recordings(panda, 3, samples=12, seed=8)
    single, both = (
        mukca.calibrate(panda, train, test=test, without=EXTENSIONS)
        for train in (one, [one, other])
    )
    stated = [c.document.uncertainty for c in (single, both)]
    assert stated[1].distance_deviation.median < stated[0].distance_deviation.median
    assert stated[1].observability_index > 0
    (placement,) = [p for p in both.errors if p.role == "test"]
    assert placement.predicted_deviation == pytest.approx(placement.found_deviation, rel=0.6)


def test_what_recordings_cannot_show_is_named(panda):
    _, train = mukca.simulate_recordings(panda, 2, samples=12, seed=8)
    found = mukca.calibrate(panda, train, without=EXTENSIONS).document
    weak = {direction.text: direction.deviation for direction in found.uncertainty.weak_directions}
    assert {"the base frame", "the ball's orientation"} <= weak.keys()
    assert "sliding along panda_joint3's axis" in weak
    assert all(0.5 < deviation <= 1.001 for deviation in weak.values())
    assert all(abs(pair.value) > 0.9 for pair in found.uncertainty.correlations)
    assert "the flange's orientation" in found.uncertainty.cannot_see[-1]
    (ball,) = [group for group in found.groups if group.name == "ball"]
    assert ball.count == 6 and ball.effective == pytest.approx(
        3, abs=0.1
    )  # its place, not its turn
    assert all(0 <= group.effective <= group.count for group in found.groups)


def test_what_no_sample_moves_is_as_unsure_as_before_in_fits_that_go_on_from_others(simulated):
    found = simulated.calibration.document
    assert any(group.name == "compliance" and group.active for group in found.groups)
    stated = [p.standard_deviation for p in found.parameters[-3:]]  # of the ball's orientation
    assert stated == pytest.approx([0.1, 0.1, 0.1])
