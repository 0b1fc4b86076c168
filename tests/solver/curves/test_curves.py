"""Joint error curves: found where they are and held out where nothing shows them."""

from dataclasses import replace

import numpy as np
import pytest
from imagined import held_out
from msgspec import structs

import mukca
from mukca.solver.calibration import FullModel, posterior_of
from mukca.solver.identification.data import Samples
from mukca.solver.identification.effects import (
    CURVE,
    KNOTS,
    SPACING,
    curve_values,
    kernel,
    random_curves,
    spectrum,
)
from mukca.solver.identification.model import Deflection
from mukca.solver.results import (
    CalibratedRobot,
    ErrorCurves,
    JointCurve,
    agreement,
    agreement_words,
)

pytestmark = pytest.mark.slow

ALONE = {"without": ("compliance", "tilt", "transmission")}
"""Curves are tried, and no other effect."""
NONE = {"without": (*ALONE["without"], "curves")}


def test_the_splines_have_the_covariance_of_the_process():
    weights = np.array([1, 4, 1]) / 6
    for length in (0.04, 0.07, 0.2):
        row = np.fft.ifft(spectrum(length)).real
        filtered = np.convolve(np.convolve(np.r_[row[-2:], row[:20]], weights), weights)[4:14]
        turns = SPACING * np.arange(10)
        assert np.allclose(filtered, kernel(2 * np.sin(turns / 2), length)[0], atol=1e-6)


def test_a_curve_is_its_derivatives_times_its_coefficients():
    generator = np.random.default_rng(0)
    q, coefficients = generator.uniform(-9, 9, (20, 3)), generator.normal(size=3 * KNOTS)
    by_coefficients = CURVE.turns(Samples.unloaded(q)) * coefficients
    each = by_coefficients.reshape(20, KNOTS, 3).sum(axis=1)
    assert np.allclose(curve_values(q, coefficients), each)
    assert np.allclose(curve_values(q + 2 * np.pi, coefficients), each)


def test_curves_are_found_in_sockets(curved):
    found, train, later = curved
    assert "curve" in found.document.deflection
    without = mukca.calibrate(found.robot, train, **NONE)
    errors = [c.validate(later).summary.test.calibrated for c in (found, without)]
    assert errors[0].mean_absolute_error < 0.85 * errors[1].mean_absolute_error


def test_an_arm_that_has_none_is_fitted_without():
    robot = mukca.load_robot("ur5e")
    _, train = mukca.simulate_recordings(robot, 3, samples=25, seed=3)
    *_, choice = mukca.calibrate(robot, train, **ALONE).document.choices
    assert choice.startswith("curves: not supported by the data")


def test_elasticity_that_the_curves_hid_is_found_beside_them():
    robot, untried = mukca.load_robot("ur5e"), ("tilt", "transmission")
    flaws = {"curves": 3e-4, "compliance": 2e-5}
    truth, (*train, test) = mukca.simulate_recordings(robot, 4, samples=20, seed=5, **flaws)
    without, found = (
        mukca.calibrate(robot, train, test=test, without=(*untried, *more))
        for more in (("curves",), ())
    )
    assert without.document.deflection == {}
    assert any("compliance: kept" in n and "beside curves" in n for n in found.document.choices)
    loaded = slice(1, 3)  # the joints that gravity loads most
    bends = found.document.deflection["compliance"][loaded]
    assert np.allclose(bends, truth.deflection.coefficients[0][loaded], atol=4e-6)
    pairs = zip(found.document.coefficients, truth.deflection.coefficients[0], strict=True)
    assert all(abs(one.value - true) < 2 * one.standard_deviation for one, true in pairs)
    assert held_out(found) < 0.8 * held_out(without)


def test_curves_are_compared_where_both_are_known():
    generator = np.random.default_rng(0)
    a, b = np.fft.irfft(generator.normal(size=(2, 60)), KNOTS) * 2e-3
    far = np.r_[np.full(180, 1e-5), np.full(180, 3e-4)]
    turn = SPACING * np.arange(KNOTS)

    def curves(values):
        one = JointCurve(
            joint="j", values=tuple(values), deviations=tuple(far), sampled=((0.0, 3.0),)
        )
        return ErrorCurves(amplitude=3e-4, length=0.07, joints=(one,))

    again = np.where(far < 1e-4, a + 1e-4 + 2e-4 * np.sin(turn), b)
    (same,), (other,) = agreement(curves(a), curves(again)), agreement(curves(a), curves(b))
    assert same.correlation > 0.999 and same.difference < same.expected
    assert abs(other.correlation) < 0.5 and "not the same" in agreement_words([other])
    assert agreement(curves(a), None) == ()


@pytest.fixture(scope="module")
def ur10(ur10_points, tmp_path_factory):
    folder = tmp_path_factory.mktemp("ur10")
    (folder / "points.csv").write_bytes(ur10_points.read_bytes())
    return mukca.read_placements(folder)[0]


@pytest.fixture(scope="module")
def of_ur10(ur10):
    """The calibration by a fourth of the points, held out another fourth."""
    train, test = some(ur10, slice(0, None, 4)), some(ur10, slice(1, None, 4))
    return mukca.calibrate(mukca.load_robot("ur10"), train, test=test)


def some(points, rows):
    return replace(points, name=str(rows), files=(), samples=points.samples[rows])


def test_a_measured_ur10_has_curves(of_ur10):
    found = of_ur10
    assert held_out(found) < 0.18e-3
    assert any(note.startswith("curves: kept") for note in found.document.choices or ())
    curves = found.document.curves
    assert curves is not None and 0.02 <= curves.length <= 0.2
    for joint in curves.joints:
        deviations = np.array(joint.deviations)
        assert (
            0.1 * curves.amplitude < deviations.min() < deviations.max() < 1.001 * curves.amplitude
        )


def test_an_earlier_calibration_is_where_the_next_one_begins(ur10, of_ur10, tmp_path):
    """None of the points are those of the earlier one."""
    robot = mukca.load_robot("ur10")
    new, test = some(ur10, slice(1, 400, 10)), some(ur10, slice(2, 400, 8))
    of_ur10.save(tmp_path / "old")
    prior = tmp_path / "old" / "calibration.json"
    alone = mukca.calibrate(robot, new, test=test, **ALONE)
    begun = mukca.calibrate(robot, new, test=test, prior=prior, remounted=("tool",), **ALONE)
    assert held_out(begun) < 0.6 * held_out(alone)
    with pytest.raises(mukca.MukcaError, match="of an arm with the joints shoulder_pan"):
        _, (data,) = mukca.simulate_recordings(mukca.load_robot("panda"), 1, samples=8)
        mukca.calibrate(mukca.load_robot("panda"), data, prior=prior)


def test_a_file_holds_the_posterior_of_its_calibration(curved):
    document = curved[0].document
    kept = posterior_of(document, "file")
    again = posterior_of(structs.replace(document, posterior=None), "file")
    assert kept.model.names == again.model.names
    assert np.allclose(kept.x, again.x, atol=1e-9) and np.allclose(kept.centres, again.centres)
    deviations = np.sqrt(np.diag(again.covariance))
    apart = np.abs(kept.covariance - again.covariance)
    assert (apart <= 0.01 * np.outer(deviations, deviations) + 1e-18).all()


def test_the_flange_of_an_arm_with_curves_alone_follows_them():
    robot = mukca.load_robot("ur5e")
    curves = Deflection(("curve",), (5e-4 * random_curves(6, np.random.default_rng(0)),))
    wiggly, rigid = (
        CalibratedRobot(robot, (), np.zeros(0), deflection) for deflection in (curves, Deflection())
    )
    q = np.random.default_rng(1).uniform(-2, 2, (5, 6))
    there = FullModel(rigid).flange(wiggly.true_positions(q))
    assert FullModel(wiggly).flange(q) == pytest.approx(there, abs=1e-12)
