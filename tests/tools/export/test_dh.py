"""DH tables: read back as a toolbox reads them, they give the URDF's kinematics exactly."""

import csv
import json
import math

import casadi as ca
import numpy as np
import pytest

from mukca.solver.robot import Origin, link_frames, load_robot, workspace
from mukca.solver.robot.urdf import Joint
from mukca.tools.export.dh import dh_table


def about_x(angle):
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[1, 0, 0, 0], [0, c, -s, 0], [0, s, c, 0], [0, 0, 0, 1]])


def about_y(angle):
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, 0, s, 0], [0, 1, 0, 0], [-s, 0, c, 0], [0, 0, 0, 1]])


def about_z(angle):
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])


def along(x=0.0, z=0.0):
    T = np.eye(4)
    T[0, 3], T[2, 3] = x, z
    return T


def forward(rows, base, tool, q, convention):
    """The textbook's product."""
    T = base
    for row, angle in zip(rows, q, strict=True):
        theta, d, a, alpha, beta = (float(row[k]) for k in ("theta", "d", "a", "alpha", "beta"))
        J = along(z=angle) if row["type"] == "prismatic" else about_z(angle)
        joint, normal = J @ about_z(theta) @ along(z=d), along(x=a) @ about_x(alpha) @ about_y(beta)
        T = T @ joint @ normal if convention == "dh" else T @ normal @ joint
    return T @ tool


def poses(joints, origins, q):
    """The pose of the last link, by the project's own kinematics, for rows of q."""
    x = ca.SX.sym("q", q.shape[1])
    R, p = link_frames(joints, ca.DM(origins.ravel()), x)[-1]
    T = ca.vertcat(ca.horzcat(R, p), ca.DM([[0, 0, 0, 1]]))
    found = ca.Function("pose", [x], [ca.densify(T)]).map(len(q))(q.T).full()
    return found.reshape(4, len(q), 4).transpose(1, 0, 2)


def read(file):
    """Rows, base and tool as the file has them."""
    if file.suffix == ".json":
        document = json.loads(file.read_text())
        return document["joints"], np.array(document["base"]), np.array(document["tool"])
    lines = file.read_text().splitlines()
    rest = {line.split()[1]: line.split()[2:] for line in lines if line.startswith("#")}
    last = [[0.0, 0.0, 0.0, 1.0]]
    base, tool = (
        np.vstack([np.array(rest[name], dtype=float).reshape(3, 4), last])
        for name in ("base", "tool")
    )
    return list(csv.DictReader(line for line in lines if line[0] != "#")), base, tool


def test_forward_kinematics_are_the_urdfs(export, imagined, tmp_path) -> None:
    file, calibration = imagined
    robot, calibrated = calibration.robot, calibration.calibrated
    q = workspace(robot, 8)
    expected = poses(robot.joints, calibrated.model.origins(calibrated.exported), q)
    for convention, name in (("dh", "table.json"), ("mdh", "table.csv")):
        out = tmp_path / name
        status, shown, _ = export(file, "--to", convention, "--out", out)
        assert status == 0 and "theta deg" in shown
        rows, base, tool = read(out)
        found = np.array([forward(rows, base, tool, each, convention) for each in q])
        assert np.abs(found - expected).max() < 1e-12
        assert np.abs(found[:, :3, 3] - calibrated.geometric_ball(q)).max() < 1e-12


def test_nearly_parallel_axes_get_hayatis_number_and_short_lengths(calibrations, export, tmp_path):
    hayati = {"dh": (1, 2), "mdh": (2, 3)}  # a row of the modified table begins with the step
    for convention, ending in (("dh", "json"), ("mdh", "json"), ("dh", "csv"), ("mdh", "csv")):
        out = tmp_path / f"{convention}.{ending}"
        _, shown, _ = export(calibrations / "ur5e.json", "--to", convention, "--out", out)
        rows, *_ = read(out)
        expected = ["hayati" if i in hayati[convention] else convention for i in range(6)]
        assert [row["form"] for row in rows] == expected
        assert all(abs(float(row["d"])) < 0.3 and abs(float(row["a"])) < 0.7 for row in rows)
        assert all((float(row["beta"]) != 0) == (row["form"] == "hayati") for row in rows)
        printed = [line.split() for line in shown.splitlines() if "_joint" in line]
        assert [words[1] for words in printed] == expected and "Hayati's parameter" in shown
        by_hand = [math.degrees(float(rows[i]["beta"])) for i in range(6)]
        assert np.abs(np.subtract(by_hand, [float(words[-1]) for words in printed])).max() < 1e-5


def test_the_nominal_ur5e_gets_its_makers_table() -> None:
    robot = load_robot("ur5e")
    table = dh_table(robot.joints, robot.origins, "standard")
    rows = [(row.theta, row.d, row.a, row.alpha) for row in table.rows[:5]]
    makers = [
        (0, 0, 0, math.pi / 2),  # d of 0.1625 stands in the base
        (0, 0, -0.425, 0),
        (0, 0, -0.3922, 0),
        (0, 0.1333, 0, math.pi / 2),
        (0, 0.0997, 0, -math.pi / 2),
    ]
    assert np.abs(np.subtract(rows, makers)).max() < 1e-12


@pytest.mark.parametrize("turn", [0.0, 1e-9, 1e-3, math.pi, math.pi - 1e-3])
@pytest.mark.parametrize("convention", ["dh", "mdh"])
def test_prismatic_slanted_and_parallel_axes(turn, convention) -> None:
    def joint(name, kind, xyz, rpy, axis):
        return Joint(name, kind, "", "", Origin(xyz, rpy), axis)

    slanted = (0.6, 0.0, -0.8)
    joints = (
        joint("foot", "fixed", (0.1, 0.2, 0.3), (0.3, 0.2, 0.1), (1.0, 0.0, 0.0)),
        joint("rail", "prismatic", (0.0, 0.1, 0.0), (0.1, 0.0, 0.0), slanted),
        joint("arm", "revolute", (0.0, 0.4, 0.0), (0.0, 0.0, 0.0), slanted),
        joint("lift", "prismatic", (0.3, 0.0, 0.0), (turn, 0.0, 0.0), slanted),
        joint("wrist", "revolute", (0.3, 0.0, 0.2), (0.0, turn, 0.4), (0.0, -1.0, 0.0)),
        joint("twist", "revolute", (0.3, 0.0, 0.2), (turn, 0.0, 0.0), (0.0, -1.0, 0.0)),
        joint("ball", "fixed", (0.0, 0.0, 0.1), (0.0, 0.5, 0.0), (1.0, 0.0, 0.0)),
    )
    origins = np.array([j.origin.xyz + j.origin.rpy for j in joints])
    table = dh_table(joints, origins, {"dh": "standard", "mdh": "modified"}[convention])
    rows = [vars(row) for row in table.rows]
    q = np.random.default_rng(0).uniform(-3, 3, (20, 5))
    found = [forward(rows, table.base, table.tool, each, convention) for each in q]
    assert np.abs(found - poses(joints, origins, q)).max() < 1e-12
