"""DH tables: read back as a toolbox reads them, they give the URDF's kinematics exactly."""

import csv
import json
import math

import numpy as np
import pytest
from imagined import configurations, dh_frames, imagine, poses

import mukca

pytest.importorskip("pinocchio", reason="the extra simulation is not installed")


def forward(rows, base, tool, q, convention):
    return base @ list(dh_frames(rows, q, convention))[-1] @ tool


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


def test_forward_kinematics_are_the_urdfs(export, imagined, tmp_path):
    file, calibration = imagined
    robot, calibrated = calibration.robot, calibration.calibrated
    q = configurations(robot, 8)
    expected = poses(calibrated.urdf().decode(), robot.tip, q)
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


def nominal(robot, calibrations):
    """A calibration that found the model to be right."""
    template = json.loads((calibrations / "fitted.json").read_text())
    return json.dumps(imagine(robot, template, off=0.0, size=0.0))


def test_the_nominal_ur5e_gets_its_makers_table(export, calibrations, tmp_path):
    file, out = tmp_path / "nominal.json", tmp_path / "table.json"
    file.write_text(nominal(mukca.load_robot("ur5e"), calibrations))
    assert export(file, "--to", "dh", "--out", out)[0] == 0
    rows = [[row[key] for key in ("theta", "d", "a", "alpha")] for row in read(out)[0][:5]]
    makers = [
        (0, 0, 0, math.pi / 2),  # d of 0.1625 stands in the base
        (0, 0, -0.425, 0),
        (0, 0, -0.3922, 0),
        (0, 0.1333, 0, math.pi / 2),
        (0, 0.0997, 0, -math.pi / 2),
    ]
    assert np.abs(np.subtract(rows, makers)).max() < 1e-12


def urdf_of(joints):
    """A chain of links, its last one the ball's."""
    links = [*(f"link{i}" for i in range(len(joints))), "ball_link"]
    text = "".join(f'<link name="{link}"/>' for link in links)
    for i, (name, kind, xyz, rpy, axis) in enumerate(joints):
        text += (
            f'<joint name="{name}" type="{kind}"><parent link="{links[i]}"/>'
            f'<child link="{links[i + 1]}"/><origin xyz="{xyz}" rpy="{rpy}"/>'
            f'<axis xyz="{axis}"/><limit lower="-9" upper="9" effort="9" velocity="9"/></joint>'
        )
    return f'<robot name="odd">{text}</robot>'


@pytest.mark.parametrize("turn", [0.0, 1e-9, 1e-3, math.pi, math.pi - 1e-3])
def test_prismatic_slanted_and_parallel_axes(export, calibrations, tmp_path, turn):
    slanted, level = "0.6 0 -0.8", "0 -1 0"
    urdf = urdf_of(
        [
            ("foot", "fixed", "0.1 0.2 0.3", "0.3 0.2 0.1", "1 0 0"),
            ("rail", "prismatic", "0 0.1 0", "0.1 0 0", slanted),
            ("arm", "revolute", "0 0.4 0", "0 0 0", slanted),
            ("lift", "prismatic", "0.3 0 0", f"{turn} 0 0", slanted),
            ("wrist", "revolute", "0.3 0 0.2", f"0 {turn} 0.4", level),
            ("twist", "revolute", "0.3 0 0.2", f"{turn} 0 0", level),
            ("ball", "fixed", "0 0 0.1", "0 0.5 0", "1 0 0"),
        ]
    )
    (tmp_path / "odd.urdf").write_text(urdf)
    robot, file = mukca.load_robot(tmp_path / "odd.urdf"), tmp_path / "odd.json"
    file.write_text(nominal(robot, calibrations))
    q = configurations(robot, 20)
    for convention in ("dh", "mdh"):
        out = tmp_path / f"{convention}.json"
        status, _, err = export(file, "--to", convention, "--out", out)
        assert status == 0, err
        rows, base, tool = read(out)
        found = [forward(rows, base, tool, each, convention) for each in q]
        assert np.abs(found - poses(urdf, "ball_link", q)).max() < 1e-12
