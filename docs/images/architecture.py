"""Draws docs/images/architecture.svg, and fills the table of docs/architecture.md, from the code.

    python docs/images/architecture.py

Each folder stands above those of its room that it imports from, so that an arrow that goes up, or
round in a circle, cannot be drawn. tests/test_architecture.py holds both against the imports.
"""

import ast
from collections.abc import Iterator, Mapping
from html import escape
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "architecture.md"
PICTURE = ROOT / "docs" / "images" / "architecture.svg"
BEGIN, END = "<!-- folders: from the code -->", "<!-- end of folders -->"
ROOMS = {
    "drivers": "robots → joint states",
    "recorder": "joint states → recordings",
    "solver": "recordings → calibrated robot",
    "tools": "command line, report, parts",
}
TYPES = {
    "drivers": ("JointState",),
    "recorder": ("Sample", "Placement"),
    "solver": ("Measurement", "Calibration"),
    "tools": (),
}
"""Types that hold a sample's joint angles, from the bytes of the robot to the calibrated URDF."""

WIDTH, BOX, STEP, TOP = 224, 200, 27, 92


def files(folder: str) -> Iterator[Path]:
    """Yield a folder's own modules."""
    yield from sorted((ROOT / folder).glob("*.py"))


def folders() -> list[str]:
    """Return the folders that hold modules beside their face, below the root, with slashes."""
    modules = (p for room in ROOMS for p in (ROOT / room).rglob("*.py"))
    found = {p.parent for p in modules if p.name != "__init__.py"}
    return sorted(p.relative_to(ROOT).as_posix() for p in found)


def imports(folder: str) -> set[str]:
    """Return the other folders that a folder's modules import from, anywhere in their text."""
    others = set[str]()
    for file in files(folder):
        package = file.relative_to(ROOT).parts[:-1]
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.level:
                base = [
                    *package[: len(package) - node.level + 1],
                    *(node.module or "").split("."),
                ]
                for alias in node.names:
                    path = [word for word in [*base, alias.name] if word]
                    while path and not (ROOT.joinpath(*path) / "__init__.py").exists():
                        path.pop()
                    others.add("/".join(path))
    return {other for other in others if other.split("/")[0] in ROOMS} - {folder}


def purpose(folder: str) -> str:
    """Return the first line of the docstring of a folder's face."""
    text = (
        ast.get_docstring(ast.parse((ROOT / folder / "__init__.py").read_text("utf-8")))
        or ""
    )
    return text.split("\n")[0].replace("``", "`").rstrip(".")


def bottom_up(graph: Mapping[str, set[str]], room: str) -> list[str]:
    """Return a room's folders, each after all that it imports from.

    Raises:
        ValueError: Folders import in a circle.
    """
    left = {
        f: {o for o in graph[f] if o.split("/")[0] == room}
        for f in graph
        if _room(f) == room
    }
    order: list[str] = []
    while left:
        free = sorted(f for f, needs in left.items() if needs <= set(order))
        if not free:
            raise ValueError(f"folders import in a circle: {', '.join(sorted(left))}")
        order += free
        left = {f: needs for f, needs in left.items() if f not in free}
    return order


def table(graph: Mapping[str, set[str]]) -> str:
    """Return the page's table of folders, in the order in which data pass through them."""
    rows = ["| folder | what it is | imports from |", "|---|---|---|"]
    for room in ROOMS:
        for folder in bottom_up(graph, room):
            below = ", ".join(f"`{other}`" for other in sorted(graph[folder]))
            rows.append(f"| `{folder}` | {purpose(folder)} | {below or 'nothing'} |")
    return "\n".join(rows)


def picture(graph: Mapping[str, set[str]]) -> str:
    """Return the picture: a column a room, its folders bottom up, and the sample's way below."""
    columns = {room: bottom_up(graph, room) for room in ROOMS}
    tallest = max(map(len, columns.values()))
    floor = TOP + STEP * tallest
    height = floor + 118
    parts: list[str] = []
    for i, (room, own) in enumerate(columns.items()):
        left = 14 + WIDTH * i
        parts += [
            f'<rect x="{left}" y="14" width="{WIDTH - 12}" height="{floor - 2}" class="room"/>',
            f'<text x="{left + 12}" y="42" class="name">{room}/</text>',
            f'<text x="{left + 12}" y="62" class="what">{escape(ROOMS[room])}</text>',
        ]
        for k, folder in enumerate(own):
            y = floor - STEP * (k + 1) + 4
            inner = folder.partition("/")[2] or "(its own files)"
            parts.append(
                f'<g><title>{escape(purpose(folder))}</title><rect x="{left + 6}" y="{y}" '
                f'width="{BOX}" height="{STEP - 5}" class="folder"/>'
                f'<text x="{left + 14}" y="{y + 15}" class="inner">{inner}</text></g>'
            )
    parts += _way(floor + 30)
    style = (
        ".room{fill:#eef2f5;stroke:#90a4ae}.folder{fill:#fff;stroke:#b0bec5}"
        ".name{font:bold 17px sans-serif;fill:#263238}.what{font:12px sans-serif;fill:#455a64}"
        ".inner{font:12px monospace;fill:#263238}.type{fill:#00897b}"
        ".word{font:bold 12px monospace;fill:#fff}.end{font:12px sans-serif;fill:#263238}"
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH * 4 + 16} {height}" '
        f'role="img"><style>{style}</style><rect width="100%" height="100%" fill="#fff"/>\n'
        + "\n".join(parts)
        + "\n</svg>\n"
    )


def _way(y: int) -> list[str]:
    """Return the way of one sample, by the types that hold its joint angles."""
    words = [(i, word) for i, room in enumerate(ROOMS) for word in TYPES[room]]
    parts = [
        f'<text x="20" y="{y}" class="end">one sample, from the robot\'s bytes to the URDF:</text>'
    ]
    for room in range(len(ROOMS)):
        own = [word for i, word in words if i == room]
        for k, word in enumerate(own):
            width = (WIDTH - 24) // len(own)
            x, end = 18 + WIDTH * room + k * width, 0
            end = x + width - 4
            corners = [(x, 14), (end - 8, 14), (end, 28), (end - 8, 42), (x, 42)]
            points = " ".join(f"{across},{y + down}" for across, down in corners)
            parts.append(f'<polygon points="{points}" class="type"/>')
            parts.append(f'<text x="{x + 8}" y="{y + 32}" class="word">{word}</text>')
    x = 24 + WIDTH * (len(ROOMS) - 1)
    return [*parts, f'<text x="{x}" y="{y + 32}" class="end">→ calibrated.urdf</text>']


def _room(folder: str) -> str:
    return folder.split("/")[0]


def main() -> None:
    """Write the picture and the page's table."""
    graph = {folder: imports(folder) for folder in folders()}
    PICTURE.write_text(picture(graph), encoding="utf-8")
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    after = rest.partition(END)[2]
    PAGE.write_text(
        f"{before}{BEGIN}\n\n{table(graph)}\n\n{END}{after}", encoding="utf-8"
    )


if __name__ == "__main__":
    main()
