"""Draw what to do by hand for one thing more: a check, zeros, a tool and its axis, cameras.

python docs/images/hold.py > docs/images/hold.svg
"""

import math

ARM, ACCENT, GROUND = "#0b6e99", "#b3541e", "#888888"
GREY = 'fill="#999" stroke="#999" stroke-width="3"'
WIDTH, HEIGHT, COLUMNS = 240, 218, 3
LINKS = (70, 62, 34)
"""Lengths of the drawn arm's links [px]."""


def arm(
    angles: tuple[float, ...], opacity: float = 1.0
) -> tuple[str, tuple[float, float]]:
    """Return an arm with its base at the lower left, and where its flange is."""
    x, y, heading = 60.0, 170.0, math.pi / 2
    points = [(x, y)]
    for length, angle in zip(LINKS, angles, strict=True):
        heading -= math.radians(angle)
        x, y = x + length * math.cos(heading), y - length * math.sin(heading)
        points.append((x, y))
    dots = " ".join(f"{a:.0f},{b:.0f}" for a, b in points)
    style = f'fill="none" stroke="{ARM}" stroke-width="5" stroke-linejoin="round"'
    return f'<polyline points="{dots}" {style} stroke-opacity="{opacity}"/>', points[-1]


def text(x: float, y: float, words: str, size: int = 13) -> str:
    return (
        f'<text x="{x}" y="{y}" font-size="{size}" text-anchor="middle">{words}</text>'
    )


def board(x: float, y: float, turn: int = 0) -> str:
    """Return a printed board."""
    squares = "".join(
        f'<rect x="{x - 16 + 8 * i}" y="{y - 12 + 8 * j}" width="8" height="8"/>'
        for i in range(4)
        for j in range(3)
        if (i + j) % 2
    )
    return (
        f'<g transform="rotate({turn} {x} {y})"><rect x="{x - 16}" y="{y - 12}" width="32" '
        f'height="24" fill="white" stroke="#222"/>{squares}</g>'
    )


def camera(x: float, y: float, turn: int) -> str:
    """Return a camera that looks to the right before its turn."""
    return (
        f'<g transform="rotate({turn} {x:.0f} {y:.0f})" fill="{ACCENT}">'
        f'<rect x="{x - 10:.0f}" y="{y - 7:.0f}" width="16" height="14" rx="2"/>'
        f'<path d="M{x + 6:.0f} {y - 3:.0f} l7 -4 v14 l-7 -4 z"/></g>'
    )


def panel(index: int, title: str, words: tuple[str, str], parts: list[str]) -> str:
    """Return one picture with its title above and two lines below."""
    ground = f'<path d="M10 170 H230" stroke="{GROUND}" stroke-width="2"/>'
    lines = [
        text(WIDTH / 2, 20, f"<tspan font-weight='bold'>{title}</tspan>", 15),
        ground,
        *parts,
    ]
    lines += [text(WIDTH / 2, 190 + 17 * i, line, 12) for i, line in enumerate(words)]
    x, y = WIDTH * (index % COLUMNS), HEIGHT * (index // COLUMNS)
    return f'<g transform="translate({x} {y})">{"".join(lines)}</g>'


def main() -> None:
    low, lower = (15.0, 85.0, 65.0), (35.0, 50.0, 85.0)
    first, tip = arm(low)
    raised, high = arm((0.0, 95.0, 75.0))
    second, _ = arm(lower, 0.35)
    ball = f'<circle cx="{tip[0]:.0f}" cy="{tip[1]:.0f}" r="6" fill="{ACCENT}"/>'
    seat = f'<path d="M{tip[0] - 14:.0f} 170 v-14 h56 v14 z" fill="#ccc"/>'
    spike = f'<path d="M{tip[0] - 7:.0f} 170 l7 -22 l7 22 z" fill="#999"/>'
    tool = (
        f'<path d="M{tip[0]:.0f} {tip[1]:.0f} L{tip[0]:.0f} 148" stroke="{ACCENT}" '
        'stroke-width="3"/>'
    )
    knock = (
        f'<path d="M50 96 l-14 -6 m13 14 h-16 m18 6 l-12 9" stroke="{ACCENT}" '
        'stroke-width="3"/>'
    )
    shaft = (
        f'<path d="M{high[0]:.0f} {high[1]:.0f} V166" stroke="{ACCENT}" stroke-width="3"/>'
        f'<circle cx="{high[0]:.0f}" cy="140" r="4" fill="{ACCENT}"/>'
    )
    beside = f'<path d="M{high[0] + 4:.0f} 140 l24 -6 v12 z M{high[0] + 28:.0f} 170 v-36" {GREY}/>'
    panels = [
        panel(0, "mukca check, validate",
              ("after a knock, or by the calendar:", "6 + 6 samples, the base anywhere"),
              [seat, second, first, ball, knock]),
        panel(1, "mukca rezero", ("ball in the sockets, 6 + 6 samples,", "all joints moved"),
              [seat, second, first, ball]),
        panel(2, "mukca tool", ("tip on one fixed point, 8 samples,", "turned as far as it goes"),
              [spike, second, first, tool]),
        panel(3, "mukca tool --axis",
              ("then a mark up the shaft on a point:", "the tool's direction, too"),
              [beside, raised, shaft]),
        panel(4, "handeye --camera on-arm", ("board fixed, 15 views,", "turned about two axes"),
              [board(190, 158), first, camera(tip[0], tip[1], 20)]),
        panel(5, "handeye --camera beside", ("camera fixed, board on the arm,", "15 views"),
              [camera(200, 60, 140), first, board(tip[0], tip[1], 30)]),
    ]  # fmt: skip
    width, height = COLUMNS * WIDTH, HEIGHT * len(panels) // COLUMNS
    print(
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
        'font-family="Helvetica, Arial, sans-serif">'
        f'<rect width="{width}" height="{height}" fill="#ffffff"/>{"".join(panels)}</svg>'
    )


if __name__ == "__main__":
    main()
