"""The C file: compiled with all warnings as errors, it is the calibration's own model."""

import ctypes
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from imagined import configurations, edited, slopes

import mukca

EXAMPLES = Path(__file__).parents[3] / "examples" / "controller"
STRICT = ("-Wall", "-Wextra", "-Wpedantic", "-Werror")
COMPILERS = {
    "gcc": "-std=c99 -O2",
    "clang": "-std=c99 -O0",
    "g++": "-x c++ -std=c++11 -O0",
    "arm-none-eabi-gcc": "-std=c99 -O2 -mcpu=cortex-m7 -mfpu=fpv5-d16 -mfloat-abi=hard",
}
"""With what each compiles, the last one for a bare microcontroller."""

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")


def compile_(*words):
    done = subprocess.run([*map(str, words)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


class Model:
    """The functions of a C file, on rows of joint positions."""

    def __init__(self, file, *words):
        library = file.with_suffix(".so" if not words else ".other.so")
        compile_(
            "cc", "-std=c99", "-O0", *STRICT, *words, "-shared", "-fPIC", file, "-o", library, "-lm"
        )
        self.file, self.name, self.compiled = file, file.stem, ctypes.CDLL(str(library))

    def __call__(self, function, q, size):
        call = getattr(self.compiled, f"{self.name}_{function}")
        out = np.empty((len(q), size))
        q = np.ascontiguousarray(q)
        to, fro, step = q.ctypes.data, out.ctypes.data, 8
        for i in range(len(q)):
            status = call(
                ctypes.c_void_p(to + step * q.shape[1] * i), ctypes.c_void_p(fro + step * size * i)
            )
            assert function != "command" or status == 0
        return out


@pytest.mark.slow
@pytest.mark.parametrize("imagined", ["ur5e", "openarm"], indirect=True)
def test_it_is_the_full_model(imagined, export, tmp_path):
    """It also commands poses as Python does."""
    file, calibration = imagined
    out = tmp_path / "arm.c"
    status, said, _ = export(file, "--to", "c", "--out", out)
    assert status == 0 and "Not in this format" not in said
    model, calibrated, robot = Model(out), calibration.calibrated, calibration.robot
    check_commands(model, robot, calibration)
    m = len(robot.actuated)
    q = configurations(robot, 400)
    assert np.abs(model("ball", q, 3) - calibration.calibrated.ball(q)).max() < 1e-12
    check_gravity(model("gravity", q[:200], m), robot, q[:200])
    true = model("true_positions", q, m)
    assert 1e-6 < np.abs(true - q).max() < 0.1
    assert np.abs(true - calibrated.true_positions(q)).max() < 1e-12
    q = np.clip(q, robot.lower + 0.05, robot.upper - 0.05)
    rigid = calibration.geometric
    regular = np.linalg.svd(rigid.jacobian(q), compute_uv=False)[:, -1] > 0.02
    commanded = model("command", q[regular], m)
    assert np.abs(calibration.flange(commanded) - rigid.flange(q[regular])).max() < 1e-9
    check_flange(model, robot, calibration, q[:200])


def check_gravity(torques, robot, q):
    """Pinocchio has the same, by the nominal model."""
    pinocchio = pytest.importorskip("pinocchio", reason="the extra simulation is not installed")
    arm = pinocchio.buildModelFromXML(robot.text.data.decode())
    arm.gravity.linear = np.array([0.0, 0.0, -9.80665])
    data = arm.createData()
    expected = [pinocchio.computeGeneralizedGravity(arm, data, row) for row in q]
    assert np.abs(torques - expected).max() < 1e-9


def check_flange(model, robot, calibration, q):
    """The flange carries the ball, and its Jacobian is its derivative."""
    m = len(robot.actuated)
    T = model("flange", q, 16).reshape(-1, 4, 4)
    assert np.all(T[:, 3] == [0, 0, 0, 1])
    calibrated = calibration.calibrated
    place = calibrated.model.origins(calibrated.values)[-1, :3]
    found = T[:, :3, :3] @ place + T[:, :3, 3]
    assert np.abs(found - calibration.calibrated.ball(q)).max() < 1e-12
    J = model("jacobian", q, 6 * m).reshape(-1, 6, m)
    change = slopes(lambda x: model("flange", x, 16), q).reshape(-1, 4, 4, m)
    assert np.abs(J[:, :3] - change[:, :3, 3]).max() < 1e-8
    W = np.einsum("nikj,nlk->nilj", change[:, :3, :3], T[:, :3, :3])
    spin = np.stack([W[:, 2, 1], W[:, 0, 2], W[:, 1, 0]], axis=1)
    assert np.abs(J[:, 3:] - spin).max() < 1e-8


class Report(ctypes.Structure):
    """What a command came to."""

    _fields_ = (
        ("distance", ctypes.c_double),
        ("angle", ctypes.c_double),
        ("rounds", ctypes.c_int),
        ("joint_at_limit", ctypes.c_int),
    )


def command_pose(model, T, near, prefer=None):
    """The status, the joint positions and the report of one call."""
    arrays = [
        None if a is None else np.ascontiguousarray(a, dtype=float) for a in (T, near, prefer)
    ]
    found, report = np.empty(len(near)), Report()
    places = [None if a is None else ctypes.c_void_p(a.ctypes.data) for a in (*arrays, found)]
    call = getattr(model.compiled, f"{model.name}_command_pose")
    return call(*places, ctypes.byref(report)), found, report


def check_commands(model, robot, calibration):
    q = np.clip(configurations(robot, 60), robot.lower + 0.1, robot.upper - 0.1)
    near = np.clip(q + 0.1 * np.sin(np.arange(q.size)).reshape(q.shape), robot.lower, robot.upper)
    solver, poses = calibration.calibrated.solver("pose"), calibration.flange(q)
    for prefer in (None, np.clip(near + 0.05, robot.lower, robot.upper)):
        expected = solver.solve(poses[:, :3].reshape(-1, 12), near, prefer)
        assert expected.reached.mean() > 0.9  # of one start alone
        for i in np.flatnonzero(expected.reached):
            wanted = None if prefer is None else prefer[i]
            status, found, report = command_pose(model, poses[i], near[i], wanted)
            assert status == 0 and report.rounds == expected.rounds[i]
            assert np.abs(found - expected.positions[i]).max() < 1e-12
    T = calibration.flange(q[0])
    T[:3, 3] += 5.0
    status, found, report = command_pose(model, T, near[0])
    assert status == -1 and 3 < report.distance < 9
    assert command_pose(model, np.full((4, 4), np.nan), near[0])[0] == -1
    assert command_pose(model, T, np.full(q.shape[1], np.nan))[0] == -1


@pytest.mark.slow
def test_commands_keep_their_tolerance_on_joints_with_play(calibrations, export, tmp_path):
    """Play of a servo turns a joint steeply where its load changes sign."""
    file = edited(calibrations / "ur5e.json", tmp_path / "play.json", with_play)
    calibration, out = mukca.load_calibration(file), tmp_path / "arm.c"
    assert export(file, "--to", "c", "--out", out)[0] == 0
    model, robot = Model(out), calibration.robot
    q = np.clip(configurations(robot, 1000), robot.lower + 0.1, robot.upper - 0.1)
    starts = np.clip(q + 0.1 * np.sin(np.arange(q.size)).reshape(q.shape), robot.lower, robot.upper)
    poses = calibration.flange(q)
    commands = [command_pose(model, T, start) for T, start in zip(poses, starts, strict=True)]
    reached = np.array([status == 0 for status, _, _ in commands])
    found = calibration.flange(np.array([positions for _, positions, _ in commands]))
    assert reached.mean() > 0.8
    assert np.abs(found - poses)[reached].max() < 1e-9


def with_play(document):
    """Give each joint the play of a servo."""
    document["deflection"]["play"] = [3e-3] * 6


@pytest.fixture(scope="module")
def arm(calibrations, tmp_path_factory):
    """The C file of a Panda, called arm."""
    out = tmp_path_factory.mktemp("c") / "arm.c"
    mukca.export(mukca.load_calibration(calibrations / "panda.json"), "c", out)
    return Model(out)


@pytest.mark.slow
@pytest.mark.parametrize("compiler", COMPILERS)
def test_it_compiles_without_a_warning(arm, tmp_path, compiler: str):
    if shutil.which(compiler) is None:
        pytest.skip(f"no {compiler}")
    compile_(compiler, *COMPILERS[compiler].split(), *STRICT, "-c", arm.file, "-o", tmp_path / "o")


@pytest.mark.slow
def test_any_name_of_a_joint_is_a_string_of_c(calibrations, tmp_path):
    name = "a\\??/é\u0085😀\x7f"

    def rename(document):
        text = json.dumps(document).replace("panda_joint1", json.dumps(name)[1:-1])
        document.update(json.loads(text))

    file = edited(calibrations / "panda.json", tmp_path / "panda.json", rename)
    mukca.export(mukca.load_calibration(file), "c", tmp_path / "odd.c")
    library = Model(tmp_path / "odd.c").compiled
    assert (ctypes.c_char_p * 7).in_dll(library, "odd_joint_names")[0].decode() == name


def test_a_program_says_when_a_pose_is_reached(arm):
    """Metres beyond reach are reached by a program that asks for no more."""
    q = np.array([0.1, 0.5, 0.2, -0.7, 0.1, 1.7, 0.8])
    T = arm("flange", q[None], 16).reshape(4, 4)
    T[0, 3] += 3.0
    assert command_pose(arm, T, q)[0] == -1
    assert command_pose(Model(arm.file, "-DARM_TOLERANCE=9"), T, q)[0] == 0


def test_what_is_no_number_is_said(arm):
    q, out = (ctypes.c_double * 7)(*[0.1] * 6, float("nan")), (ctypes.c_double * 7)()
    assert arm.compiled.arm_command(q, out) == -1


def test_it_needs_nothing_and_keeps_nothing(arm):
    text = arm.file.read_text()
    assert re.findall(r"#include .*", text) == ['#include "arm.h"', "#include <math.h>"]
    assert not re.search(r"alloc|casadi|^static double \w+;", text, re.M)
    assert "sha256" in text and '"panda_joint7"' in text


@pytest.mark.slow
def test_the_examples_run(arm, calibrations, tmp_path):
    folder, loop = arm.file.parent, tmp_path / "loop"
    words = [f"-I{folder}", EXAMPLES / "loop.cpp", folder / "arm.so", f"-Wl,-rpath,{folder}"]
    compile_("c++", "-std=c++11", *STRICT, *words, "-o", loop)
    shown = subprocess.run([loop, "50"], capture_output=True, text=True).stdout
    assert "slowest of 50 cycles" in shown
    script = [sys.executable, EXAMPLES / "from_python.py", folder / "arm.so", "7"]
    shown = subprocess.run(script, capture_output=True, text=True, check=True).stdout
    ball = np.array([float(word) for word in shown.splitlines()[0].split(":")[1].split()])
    calibration = mukca.load_calibration(calibrations / "panda.json")
    middle = (calibration.robot.lower.clip(-3) + calibration.robot.upper.clip(max=3)) / 2
    expected = calibration.calibrated.ball(middle + 0.3)
    assert np.abs(ball - expected).max() < 1e-12


@pytest.mark.slow
def test_it_holds_a_payload_and_another_link_may_be_the_flange(export, calibrations, tmp_path):
    file, out = calibrations / "panda.json", tmp_path / "loaded.c"
    words = ("--payload", "2", "--payload-at", "0", "0", "0.1", "--flange", "panda_link8")
    assert export(file, "--to", "c", "--out", out, *words)[0] == 0
    assert "pose of panda_link8" in out.with_suffix(".h").read_text()
    arm, q = mukca.load_calibration(file), np.array([0.1, -0.4, 0.2, -2.0, 0.1, 1.7, 0.8])
    q = np.array([q, q + 0.2])
    first, second = Model(out)("flange", q, 16).reshape(2, 4, 4)
    for how, within in (({"payload": (2.0, (0, 0, 0.1))}, True), ({}, False)):
        one, other = arm.flange(q, **how)  # one link is where the other is, seen from either
        off = np.abs(other @ np.linalg.inv(one) @ first - second).max()
        assert off < 1e-12 if within else off > 1e-5
