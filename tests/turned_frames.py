"""The same arm drawn otherwise: each link's frame turned at random, and all that is given in it."""

import xml.etree.ElementTree as ET

import numpy as np

from mukca.solver.identification.robot import Robot, matrix_rpy, parse_robot, rpy_of, scan, turn


def turned_frames(robot: Robot, seed: int = 0) -> Robot:
    """Return a robot with turned frames of its links, but for the base and the ball.

    With R' = Q_parent^T R Q_child, p' = Q_parent^T p and the axis a' = Q_child^T a, every point of
    the arm stays where it is.
    """
    generator = np.random.default_rng(seed)
    root = ET.fromstring(robot.text.data)
    Q = {link.get("name"): turn(generator.uniform(-2, 2, 3)) for link in root.iter("link")}
    Q[robot.base] = Q[robot.tip] = np.eye(3)
    for link in root.iter("link"):
        for part in link.iter("origin"):
            _write(part, Q[link.get("name")].T, np.eye(3))
    for joint in root.iter("joint"):
        parent, child = (Q[joint.find(role).get("link")] for role in ("parent", "child"))
        origin = joint.find("origin")
        _write(ET.SubElement(joint, "origin") if origin is None else origin, parent.T, child)
        if joint.get("type") != "fixed":
            axis = joint.find("axis")
            axis = ET.SubElement(joint, "axis", xyz="1 0 0") if axis is None else axis
            axis.set("xyz", _words(child.T @ _numbers(axis, "xyz")))
    text = scan(ET.tostring(root), robot.text.source)
    return parse_robot(text, base=robot.base, tip=robot.tip)


def _write(origin: ET.Element, before: np.ndarray, after: np.ndarray) -> None:
    xyz, rpy = (_numbers(origin, key) for key in ("xyz", "rpy"))
    origin.set("xyz", _words(before @ xyz))
    origin.set("rpy", _words(rpy_of(before @ matrix_rpy(rpy) @ after)))


def _numbers(element: ET.Element, key: str) -> np.ndarray:
    return np.array([float(word) for word in element.get(key, "0 0 0").split()])


def _words(numbers) -> str:
    return " ".join(repr(float(number)) for number in numbers)
