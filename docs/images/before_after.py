"""Draw the README's first picture from recordings of a real arm.

    python docs/images/before_after.py RECORDINGS TRAINED_ON > docs/images/before-after.svg

Every held-out sample is a dot: its predicted ball centre less the mean of its socket, seen from
above. The nominal side has the ball's place fitted, the calibrated one is the exported URDF alone.
"""

import sys
from pathlib import Path

import numpy as np

import mukca

SCALE = 17.5e3
"""Pixels for a metre."""
RINGS = (2, 4, 6)
"""[mm]."""


def deviations(points: np.ndarray, sockets: np.ndarray) -> np.ndarray:
    means = np.array(
        [points[sockets == k].mean(axis=0) for k in range(sockets.max() + 1)]
    )
    return points - means[sockets]


def panel(title: str, centre: float, errors: np.ndarray) -> list[str]:
    words = 'text-anchor="middle" fill="#222">'
    lines = [f'<text x="{centre}" y="34" font-size="20" {words}{title}</text>']
    for ring in RINGS:
        r = ring * SCALE / 1e3
        lines.append(
            f'<circle cx="{centre}" cy="178" r="{r}" fill="none" stroke="#ddd"/>'
        )
        x, y = centre + 0.74 * r, 178 - 0.74 * r
        lines.append(
            f'<text x="{x:.0f}" y="{y:.0f}" font-size="11" fill="#999">{ring} mm</text>'
        )
    for x, y, _ in errors * SCALE:
        dot = f'cx="{centre + x:.1f}" cy="{178 - y:.1f}" r="2.2"'
        lines.append(f'<circle {dot} fill="#0b6e99" fill-opacity="0.55"/>')
    mean = 1e3 * np.linalg.norm(errors, axis=1).mean()
    label = f"mean error {mean:.2f} mm"
    lines.append(f'<text x="{centre}" y="316" font-size="17" {words}{label}</text>')
    return lines


def main() -> None:
    folder, trained_on = Path(sys.argv[1]), sys.argv[2]
    robot = mukca.load_robot(folder / "nominal.urdf")
    everything = mukca.read_placements(folder)
    train = [p for p in everything if p.path == folder / trained_on]
    ball_alone = {"method": "paper", "free": [f"{robot.ball_joint.name}.xyz"]}
    models = {
        "nominal URDF": mukca.calibrate(robot, train, **ball_alone).calibrated.ball,
        "calibrated URDF": mukca.calibrate(robot, train).calibrated.geometric_ball,
    }
    head = 'xmlns="http://www.w3.org/2000/svg" viewBox="0 0 860 330"'
    lines = [f'<svg {head} font-family="Helvetica, Arial, sans-serif">']
    lines.append('<rect width="860" height="330" fill="#ffffff"/>')
    for (title, ball), centre in zip(models.items(), (223.6, 636.4), strict=True):
        held_out = [p for p in everything if p not in train]
        errors = [deviations(ball(p.positions), p.sockets) for p in held_out]
        lines += panel(title, centre, np.concatenate(errors))
    print("\n".join([*lines, "</svg>"]))


if __name__ == "__main__":
    main()
