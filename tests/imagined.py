"""Calibrations made without any fit, and where Pinocchio has the links of a URDF."""

import json
import math

import numpy as np

COMPONENTS = ("x", "y", "z", "roll", "pitch", "yaw")
DH = ("theta", "d", "a", "alpha", "beta")
SIZES = {"zero": 1, "compliance": 1, "tilt": 2, "play": 1, "harmonic_1": 2, "harmonic_2": 2}
SIZES["curve"] = 360
"""Coefficients of each correction, for each joint."""


def configurations(robot, count, seed=0):
    """Joint positions at random, shape (count, m)."""
    return np.random.default_rng([seed, 5]).uniform(-1.5, 1.5, (count, len(robot.joint_names)))


def imagine(robot, template, off=2e-3, size=2e-5):
    """A calibration of a robot: every number off by some of ``off``, all joints corrected."""
    rng = np.random.default_rng([0, len(robot.joints)])
    by_component = {value["component"]: value for value in template["parameters"]}
    values = []
    for joint in robot.joints:
        if not joint.actuated and joint is not robot.ball_joint:
            continue
        nominals = (*joint.origin.xyz, *joint.origin.rpy)
        for component, nominal in zip(COMPONENTS, nominals, strict=True):
            change, other = rng.normal(0, off, 2).tolist()
            called = {"name": f"{joint.name}.{component}", "joint": joint.name}
            found = {"nominal": nominal, "calibrated": nominal + change, "change": change}
            exported = {"exported": nominal + change + 0.1 * other}
            values.append(by_component[component] | called | found | exported)
    m = len(robot.joint_names)
    corrections = {key: rng.uniform(0, size, m * n).tolist() for key, n in SIZES.items()}
    samples = [
        {"socket": i % 2, "position": q, "effort": None}
        for i, q in enumerate(configurations(robot, 20).tolist())
    ]
    model = {key: getattr(robot, key) for key in ("name", "source", "base", "tip")}
    model |= {"joint_names": list(robot.joint_names), "nominal_urdf": robot.text.data.decode()}
    data = {"name": "a/b", "role": "train", "distance": 0.05, "files": [], "samples": samples}
    return {
        **template,
        "parameters": values,
        "deflection": corrections if size else {},
        "data": [data],
        "model": {**template["model"], **model},
    }


def held_out(calibration):
    """The mean error at placements that were held out [m]."""
    return calibration.errors.summary.test.calibrated.mean_absolute_error


def edited(file, out, change):
    """Write a calibration again, with something changed in it."""
    document = json.loads(file.read_text())
    change(document)
    out.write_text(json.dumps(document))
    return out


def slopes(function, x, step=1e-6):
    """Central differences of a function by each column of its argument, along a last axis."""
    steps = step * np.eye(x.shape[-1])
    return np.stack([(function(x + s) - function(x - s)) / (2 * step) for s in steps], axis=-1)


def turned(x=0.0, y=0.0, z=0.0):
    """The turn about x, then y, then z, as the roll, pitch and yaw of a URDF, shape (4, 4)."""
    T = np.eye(4)
    for axis, angle in enumerate((x, y, z)):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        R = np.eye(4)
        R[i, i] = R[j, j] = math.cos(angle)
        R[j, i], R[i, j] = math.sin(angle), -math.sin(angle)
        T = R @ T
    return T


def along(x=0.0, z=0.0):
    """The shift along x and z, shape (4, 4)."""
    T = np.eye(4)
    T[0, 3], T[2, 3] = x, z
    return T


def dh_frames(rows, q, convention):
    """Yield where each joint's frame is by a Denavit-Hartenberg table, the textbook's product."""
    T = np.eye(4)
    for row, value in zip(rows, q, strict=True):
        theta, d, a, alpha, beta = (float(row.get(k, 0)) for k in DH)
        slides = row.get("type") == "prismatic"
        joint = turned(z=theta + value * (not slides)) @ along(z=d + value * slides)
        normal = along(x=a) @ turned(x=alpha) @ turned(y=beta)
        T = T @ (joint @ normal if convention == "dh" else normal @ joint)
        yield T


def rigid(origin):
    """The transform of a URDF origin, shape (4, 4)."""
    T = turned(*origin[3:])
    T[:3, 3] = origin[:3]
    return T


def poses(urdf, link, q):
    """Where Pinocchio has a link, shape (N, 4, 4)."""
    import pinocchio

    model = pinocchio.buildModelFromXML(urdf)
    data = model.createData()
    found = []
    for row in q:
        pinocchio.framesForwardKinematics(model, data, row)
        found.append(data.oMf[model.getFrameId(link)].homogeneous.copy())
    return np.array(found)
