"""Draw two simulated arms that visit the same bases, from above, as docs/frames.md shows them.

PYTHONPATH=benchmarks python docs/images/frames.py > docs/images/frames.svg
"""

import numpy as np
from worlds import recorded_by_both

from mukca.solver.identification.data import IDENTITY, Pose
from mukca.solver.identification.robot import Robot, link_poses, load_robot, turn
from mukca.tools.simulation import Base

SCALE = 360
"""Pixels for a metre."""
LEFT = (150, 300)
"""Where the first base is drawn."""
COLOURS = ("#0b6e99", "#b3541e")
BASES = (
    ("front", (0.6, 0.0, 0.15)),
    ("left", (0.55, 0.35, 0.3)),
    ("right", (0.65, -0.35, 0.1)),
)


def drawn(points: np.ndarray) -> list[tuple[float, float]]:
    """Return points in the plane of the picture, x to the right and y upwards."""
    return [(LEFT[0] + SCALE * x, LEFT[1] - SCALE * y) for x, y, _ in points]


def skeleton(robot: Robot, pose: Pose, q: np.ndarray) -> np.ndarray:
    """Return the places of an arm's joints in the world."""
    return pose.apply(link_poses(robot.joints, q[None])[0, :, :, 3])


def arm(robot: Robot, pose: Pose, q: np.ndarray, colour: str, opacity: float) -> str:
    dots = " ".join(f"{x:.1f},{y:.1f}" for x, y in drawn(skeleton(robot, pose, q)))
    style = f'fill="none" stroke="{colour}" stroke-width="3" stroke-linejoin="round"'
    return f'<polyline points="{dots}" {style} stroke-opacity="{opacity}"/>'


def frame(pose: Pose, name: str) -> list[str]:
    """Return the axes of a frame, and its name."""
    (x, y), *ends = drawn(pose.apply(np.array([[0, 0, 0], [0.12, 0, 0], [0, 0.12, 0]])))
    lines = [
        f'<line x1="{x:.1f}" y1="{y:.1f}" x2="{a:.1f}" y2="{b:.1f}" stroke="{colour}" '
        'stroke-width="2"/>'
        for (a, b), colour in zip(ends, ("#c33", "#393"), strict=True)
    ]
    words = 'font-size="14" fill="#222" text-anchor="middle"'
    return [*lines, f'<text x="{x:.1f}" y="{y + 62:.1f}" {words}>{name}</text>']


def main() -> None:
    robot, poses = (
        load_robot("panda"),
        (IDENTITY, Pose(turn(np.array([0, 0, np.pi])), np.array([1.2, 0, 0]))),
    )
    bases = [
        Base(name, np.array(place), np.array([0.0, 1.0, 0.0])) for name, place in BASES
    ]
    recorded = recorded_by_both(
        [robot, robot], poses, bases, np.random.default_rng(1), samples=2
    )
    lines = ['<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 740 560" '
             'font-family="Helvetica, Arial, sans-serif">',
             '<rect width="740" height="560" fill="#ffffff"/>']  # fmt: skip
    for own, pose, colour in zip(recorded, poses, COLOURS, strict=True):
        for placement in own:
            lines += [
                arm(robot, pose, q, colour, 0.45) for q in placement.positions[:1]
            ]
    for base in bases:
        for x, y in drawn(np.array(base.sockets)):
            lines.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="6" fill="#222"/>')
        (x, y), *_ = drawn(base.centre[None])
        lines.append(f'<text x="{x:.1f}" y="{y - 22:.1f}" font-size="14" fill="#222" '
                     f'text-anchor="middle">{base.name}</text>')  # fmt: skip
    lines += frame(poses[0], "base of left = world") + frame(
        poses[1], "base of right, unknown"
    )
    print("\n".join([*lines, "</svg>"]))


if __name__ == "__main__":
    main()
