"""The C file of deviations: compiled with all warnings as errors, it says what Python says."""

import ctypes
import shutil
import subprocess

import numpy as np
import pytest
from stored import STORED

import mukca
from mukca.solver.identification.robot import workspace

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
ARM = STORED / "1.0" / "calibrated" / "calibration.json"
COMPILE = ["cc", "-std=c99", "-O1", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-shared", "-fPIC"]
FLAWS = {"compliance": 5e-5, "tilt": 3e-5, "transmission": 2e-4}


class Deviations:
    """The functions of the C file, for rows of joint positions."""

    def __init__(self, export, calibration, folder, *words):
        file, library = folder / "known.c", folder / "known.so"
        status, shown, error = export(calibration, "--to", "c-deviation", "--out", file, *words)
        assert status == 0 and "single precision" in shown, error
        subprocess.run([*COMPILE, file, "-o", library, "-lm"], check=True)
        self.compiled = ctypes.CDLL(str(library))
        self.compiled.known_of_distance.restype = ctypes.c_double

    def _call(self, name, *rows):
        rows = [np.ascontiguousarray(row) for row in rows]
        places = [ctypes.c_void_p(row.ctypes.data) for row in rows]
        return getattr(self.compiled, name)(*places)

    def _matrices(self, name, *rows):
        found = np.empty((len(rows[-1]), 6, 6))
        for C, row in zip(found, rows[-1], strict=True):
            self._call(name, *rows[:-1], row, C)
        return found

    def __call__(self, q):
        return self._matrices("known", q)

    def of_movements(self, start, q):
        return self._matrices("known_of_movement", start, q)

    def of_distances(self, start, q):
        return np.array([self._call("known_of_distance", start, row) for row in q])


def near(found, expected, rel):
    """Whether matrices are others, by the deviations of the axes."""
    deviations = np.sqrt(np.diagonal(expected, axis1=1, axis2=2))
    scale = deviations[:, :, None] * deviations[:, None]
    return np.abs((found - expected) / scale).max() < rel


def test_of_a_rigid_arm_it_is_what_python_says(export, tmp_path):
    arm, known = mukca.load_calibration(ARM), Deviations(export, ARM, tmp_path)
    q = workspace(arm.robot, 20)
    assert arm.misfit > 0
    assert near(known(q), arm.deviation(q), 1e-5)
    assert near(known.of_movements(q[0], q[1:]), arm.deviation(q[1:], relative_to=q[0]), 1e-4)
    distances = arm.distance_deviation(q[1:], q[0])
    assert known.of_distances(q[0], q[1:]) == pytest.approx(distances, rel=1e-5)
    assert np.isnan(known(np.full((1, 7), np.nan))).all()


def test_of_the_ball_its_place_on_the_flange_counts(export, tmp_path):
    arm = mukca.load_calibration(ARM)
    known = Deviations(export, ARM, tmp_path, "--flange", "ball_link")
    q = workspace(arm.robot, 10)
    assert near(known(q), arm.deviation(q, tool="ball_link"), 1e-4)
    movements = arm.deviation(q[1:], relative_to=q[0], tool="ball_link")
    assert near(known.of_movements(q[0], q[1:]), movements, 1e-4)


@pytest.fixture(scope="module")
def bent():
    """A calibration with joints that give way, tilt, and turn unevenly."""
    robot = mukca.load_robot("ur5e")
    _, placements = mukca.simulate_recordings(robot, 2, samples=20, seed=2, **FLAWS)
    return mukca.calibrate(robot, placements, without=("curves",))


@pytest.mark.slow
def test_corrected_joints_and_another_load_count(export, bent, tmp_path):
    bent.save(tmp_path / "bent")
    known, q = Deviations(export, tmp_path / "bent", tmp_path), workspace(bent.robot, 20)
    assert bent.calibrated.deflection.extensions
    assert near(known(q), bent.deviation(q), 1e-4)
    movements = bent.deviation(q[1:], relative_to=q[0])
    assert near(known.of_movements(q[0], q[1:]), movements, 1e-3)


@pytest.mark.slow
def test_error_curves_count_to_a_tenth(export, curved, tmp_path):
    """Between the angles that are kept the deviation is rather larger than smaller."""
    arm = curved[0]
    assert arm.calibrated.deflection.curves is not None
    arm.save(tmp_path / "curved")
    known, q = Deviations(export, tmp_path / "curved", tmp_path), workspace(arm.robot, 30)
    traces = [
        (known(q), arm.deviation(q)),
        (known.of_movements(q[0], q[1:]), arm.deviation(q[1:], relative_to=q[0])),
    ]
    for found, expected in traces:
        ratios = np.trace(found, axis1=1, axis2=2) / np.trace(expected, axis1=1, axis2=2)
        assert np.sqrt(ratios).min() > 0.9 and np.sqrt(ratios).max() < 1.2
        assert abs(np.median(np.sqrt(ratios)) - 1) < 0.05


def test_a_calibration_without_covariance_is_refused(refused, calibrations, tmp_path):
    words = ("--to", "c-deviation", "--out", tmp_path / "known.c")
    refused("holds no covariance", "export", calibrations / "panda.json", *words)
