"""``mukca print-parts`` and ``plan``: parts to print, and what to record, before there is data."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from functools import partial
from importlib.util import find_spec
from itertools import pairwise, product
from pathlib import Path
from typing import Any

from ....errors import fixed
from ....solver import assessment, design
from ....solver.calibration import UsageError
from ....solver.results import refuse_existing, write_files
from ... import printables
from ...report.plots import from_above, to_scale
from .. import Options, OutputOptions, RobotOptions, Terminal, WorkerOptions, option


class _BaseOptions(Options, group="socket base"):
    sockets: int = 2
    distance: float = 0.1
    height_mm: float = 30.0
    clearance_mm: float = 0.5
    anchor: str | None = option(
        None,
        "add a clip for the base plate of this arm",
        choices=printables.ARMS,
        needs="plate_mm",
    )
    plate_mm: tuple[float, float] | None = None


class _BallOptions(Options, group="ball"):
    ball_diameter_mm: float = 20.0
    bought_ball: bool = False
    neck_mm: float | None = None
    reach_mm: float | None = None


class _MountOptions(Options, group="a mount of your own"):
    bolt_circle_mm: float | None = None
    bolts: int | None = None
    screw: str | None = option(
        None,
        "screws for the holes (default: M6)",
        choices=printables.SCREWS,
        needs="bolt_circle_mm",
    )
    grip_mm: tuple[float, float, float] | None = None


class _PrintPartsOptions(_BaseOptions, _BallOptions, _MountOptions, OutputOptions):
    out: Path = option(..., "folder to write to", "DIR")
    mount: Sequence[str] | None = None
    format: Sequence[str] = option(
        ("stl", "3mf", "svg"),
        "formats of the files (default: stl 3mf svg, a drawing); step needs mukca[step]",
        choices=printables.FORMATS,
    )
    author: str = "mukca"


def run_print_parts(options: _PrintPartsOptions, terminal: Terminal) -> int:
    """Build, check and write the parts."""
    base = _socket_base(options)
    balls = _balls(options)
    if find_spec("manifold3d") is None:
        raise printables.PrintableError(
            "the parts are cut by manifold3d, which is not installed: pip install 'mukca[print]'"
        )
    kinds = list(dict.fromkeys(options.format))
    tables: dict[str, bytes] = {}
    if isinstance(base, printables.AnchoredBase):
        tables[f"sockets-at-{base.arm}.csv"] = base.sockets_at().encode()
    names = [
        f"{part}.{suffix}"
        for part, suffix in product((*printables.part_names(base), *balls), kinds)
    ]
    names += tables
    refuse_existing(options.out, names, force=options.force)
    with terminal.console.status("building and checking the parts"):
        parts = list(printables.build_parts(base, balls))
        contents = [
            printables.encode(suffix, part, options.author)
            for part, suffix in product(parts, kinds)
        ]
    write_files(
        options.out, dict(zip(names, (*contents, *tables.values()), strict=True))
    )
    suffixes = ", ".join(f".{suffix}" for suffix in options.format)
    for part in parts:
        size = " x ".join(f"{1000 * edge:.0f}" for edge in part.facts["size"])
        volume = f"{part.facts['volume'] * 1e6:.0f} cm3"
        terminal.say(f"{options.out / part.name} ({suffixes})   {size} mm, {volume}")
        terminal.say(f"  {part.making}")
        terminal.say(*(f"  {line}" for line in part.lines))
    outputs = [str(options.out / name) for name in names]
    terminal.emit({"parts": [dict(part.facts) for part in parts], "outputs": outputs})
    return 0


def _socket_base(options: _PrintPartsOptions) -> printables.SocketBase:
    lengths: dict[str, Any] = {
        "distance": 1000 * options.distance,
        "sockets": options.sockets,
        "ball": options.ball_diameter_mm,
        "clearance": options.clearance_mm,
        "height": options.height_mm,
    }
    arm = options.anchor
    plate = options.plate_mm
    if arm is None or plate is None:
        return printables.SocketBase(**lengths)
    return printables.AnchoredBase(arm=arm, width=plate[0], front=plate[1], **lengths)


def _balls(options: _PrintPartsOptions) -> Mapping[str, printables.BallPart]:
    """Return a ball on each mount that was asked for: named ones, the user's own, or else all."""
    mounts: dict[str, printables.Mount] = {}
    if options.bolt_circle_mm is not None:
        bolts = 4 if options.bolts is None else options.bolts
        mounts["bolt-circle"] = printables.bolt_circle(
            options.bolt_circle_mm, bolts, options.screw or "M6"
        )
    if options.grip_mm:
        mounts["gripper"] = printables.grip(*options.grip_mm)
    if "none" in (names := options.mount or ()) and (mounts or len(names) > 1):
        raise printables.PrintableError("--mount none stands alone")
    named: dict[str, printables.Mount] = {}
    for alias in filter("none".__ne__, names):
        mount = printables.find_mount(alias)
        shipped = (name for name, one in printables.MOUNTS.items() if one is mount)
        named[next(shipped, alias)] = mount
    mounts = named | mounts
    if options.mount is None:
        mounts = mounts or dict(printables.MOUNTS)
    if options.reach_mm is not None and len(mounts) != 1:
        raise printables.PrintableError(
            "--reach-mm goes with one mount: name it with --mount"
        )
    sizes: dict[str, Any] = {
        "ball": options.ball_diameter_mm,
        "neck": options.neck_mm,
        "reach": options.reach_mm,
        "bought": options.bought_ball,
    }
    if not mounts and (options.neck_mm is not None or options.bought_ball):
        raise printables.PrintableError("--neck-mm and --bought-ball go with a mount")
    balls: dict[str, printables.BallPart] = {}
    for name, mount in mounts.items():
        try:
            balls[f"ball-{name}"] = printables.BallPart(mount, **sizes)
        except printables.PrintableError as error:
            raise printables.PrintableError(f"ball-{name}: {error}") from None
    return balls


class _PlanOptions(RobotOptions, WorkerOptions, OutputOptions):
    placements: int = 3
    samples: int = 12
    distance: Sequence[float] = (0.1, 0.15, 0.05)
    turn: float | None = None
    out: Path | None = None
    force: bool = False


def run_plan(options: _PlanOptions, terminal: Terminal) -> int:
    """Show the table, and write the picture."""
    out = options.out
    if out:
        if out.suffix.lower() != ".svg":
            raise UsageError(
                f"--out {out}: the picture is an SVG; end its name in .svg"
            )
        refuse_existing(out.parent, [out.name], force=options.force)
    robot = options.load_robot()
    work = partial(
        design.plan, robot, placements=options.placements, samples=options.samples
    )
    plans: list[design.Plan] = []
    for turn in [None] if options.turn is None else [None, options.turn]:
        with terminal.progress(len(options.distance)) as progress:
            plans += options.workers.map(
                partial(work, turn=turn),
                options.distance,
                lambda i: progress(f"sockets {1e3 * options.distance[i]:g} mm apart"),
            )
    _show(plans, options, terminal)
    if out:
        write_files(out.parent, {out.name: _picture(robot.name, plans[0])})
        terminal.say(f"Picture: {out}")
    advice = design.curve_advice(robot)
    if advice:
        terminal.say(advice)
    rows = [asdict(row) for row in plans]
    document = {"robot": options.robot, "samples": options.samples, "plans": rows}
    terminal.emit({**document, "advice": advice})
    return 0


_STYLE = """
svg { background: white; font: 12px sans-serif; }
.end { text-anchor: end; }
.middle { text-anchor: middle; }
.grid { stroke: #ddd; }
.robot { fill: #444; }
.base { fill: #1f5fbf; }
.number { fill: white; }
"""


def _picture(robot: str, planned: "design.Plan") -> bytes:
    """Return the placements seen from above, as SVG, in their order."""
    seen = from_above([(0, 0, 0), *planned.places])
    labels = "to the right of the robot, m", "before it, m"
    panel = to_scale(f"{robot}, from above", seen, labels, room=0.15)
    panel.dot(0, 0, "robot", size=14)
    for number, (sideways, before) in enumerate(seen[1:].tolist(), 1):
        panel.dot(sideways, before, "base", size=10)
        x, y = panel.x(sideways), panel.y(before)
        panel.text(x, y + 4, str(number), "middle number")
        panel.text(x, y + 24, f"{1e3 * planned.predicted[number - 1]:.2f} mm", "middle")
    return panel.file(_STYLE)


def _show(
    plans: "list[design.Plan]", options: _PlanOptions, terminal: Terminal
) -> None:
    counts = range(1, options.placements + 1)
    columns = (assessment.plural(count, "placement") for count in counts)
    heads = ["sockets apart", *columns]
    rows: list[list[str]] = []
    for row in sorted(plans, key=lambda plan: plan.distance):
        cells = [f"{1e3 * error:.2f}" for error in row.predicted]
        cells += ["-"] * (options.placements - len(cells))
        within = "" if row.turn is None else f", within {row.turn:g} deg"
        rows.append([f"{1e3 * row.distance:g} mm{within}", *cells])
    words = "Predicted error of a distance in the workspace [mm]"
    title = f"{words}, with {options.samples} samples in each socket"
    terminal.tabulate(title, heads, rows)
    first, *_ = places = plans[0].places
    axes = zip("xyz", first, strict=True)
    place = " ".join(f"{axis} {fixed(value, 2, '+')}" for axis, value in axes)
    steps = [f"1 at {place} m in the frame of the robot's base"]
    for i, pair in enumerate(pairwise(places), 1):
        steps.append(f"from {i} to {i + 1}: {design.in_words(*pair)}")
    terminal.say(f"Put the socket base, as seen from the robot: {'; '.join(steps)}.")
