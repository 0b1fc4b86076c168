"""Draws the error curves of a calibration: python docs/images/joint_error_curves.py CALIBRATION.

The picture in the docs is that of 150 points of the UR10 that docs/joint_error_curves.md names.
"""

import sys
from pathlib import Path

import numpy as np

import mukca

WIDTH, HEIGHT, GAP = 360, 120, 34


def main() -> None:
    calibration = mukca.load_calibration(sys.argv[1])
    curves = calibration.document.curves
    assert curves is not None
    train = [p for p in calibration.document.data if p.role == "train"]
    q = np.array([s.position for p in train for s in p.samples])
    rows = (len(curves.joints) + 1) // 2
    high = 1e3 * max(np.max(np.abs(c.values) + c.deviations) for c in curves.joints)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {2 * WIDTH + GAP} '
        f'{rows * (HEIGHT + GAP)}" font-family="sans-serif" font-size="11">',
        '<rect width="100%" height="100%" fill="white"/>',
    ]
    for k, curve in enumerate(curves.joints):
        left, top = (k % 2) * (WIDTH + GAP), (k // 2) * (HEIGHT + GAP) + 18
        order = np.roll(np.arange(360), 180)
        x = left + WIDTH * np.arange(360) / 360
        value, band = (
            1e3 * np.array(v)[order] for v in (curve.values, curve.deviations)
        )
        middle, scale = top + HEIGHT / 2, HEIGHT / 2 / high
        upper, lower = middle - scale * (value + band), middle - scale * (value - band)
        area = [*zip(x, upper, strict=True), *zip(x[::-1], lower[::-1], strict=True)]
        line = zip(x, middle - scale * value, strict=True)
        names = " ".join(f"{a:.1f},{b:.1f}" for a, b in area)
        path = " ".join(f"{a:.1f},{b:.1f}" for a, b in line)
        angles = (np.degrees(q[:, k]) + 180) % 360
        ticks = "".join(
            f"M{left + WIDTH * a / 360:.1f} {top + HEIGHT}v5" for a in angles
        )
        parts += [
            f'<text x="{left}" y="{top - 5}">{curve.joint}: -180 to 180 degrees, '
            f"&#177;{high:.1f} mrad</text>",
            f'<polygon points="{names}" fill="#cfe0f5"/>',
            f'<path d="M{left} {middle}h{WIDTH}" stroke="#999" stroke-width="0.7"/>',
            f'<polyline points="{path}" fill="none" stroke="#0b5cad" stroke-width="1.4"/>',
            f'<path d="{ticks}" stroke="#555" stroke-width="0.6"/>',
        ]
    file = Path(__file__).with_suffix(".svg")
    file.write_text("\n".join([*parts, "</svg>"]) + "\n")


if __name__ == "__main__":
    main()
