"""``mukca print-parts``: the socket base and the ball as files for a 3D printer."""

from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from itertools import product
from pathlib import Path
from typing import Any

from ....solver.results import refuse_existing, write_files
from ... import printables
from .. import Options, OutputOptions, Terminal, option


class _BaseOptions(Options, group="socket base"):
    sockets: int = option(2, "number of sockets: 2, or 3 in a triangle", "N")
    distance: float = option(0.1, "distance of the sockets' centres, in metres", "M")
    height_mm: float = option(
        30.0, "height of the sockets' centres above the table", "MM"
    )
    clearance_mm: float = option(
        0.5, "gap between ball and seat, beside the pads", "MM"
    )
    anchor: str | None = option(
        None,
        "add a clip for the base plate of this arm",
        choices=printables.ARMS,
        needs="plate_mm",
    )
    plate_mm: tuple[float, float] | None = option(
        None,
        "two measures of the arm's plate: its width at the front edge, and the distance from "
        "that edge to the first joint's axis",
        ("WIDTH", "FRONT"),
        needs="anchor",
    )


class _BallOptions(Options, group="ball"):
    ball_diameter_mm: float = option(20.0, "diameter of the ball, in all parts", "MM")
    bought_ball: bool = option(False, "make a cup, into which you glue a bearing ball")
    neck_mm: float | None = option(
        None, "diameter of the neck at the ball (default: 0.45 of the ball's)", "MM"
    )
    reach_mm: float | None = option(
        None, "distance from the flange to the ball's centre, for one mount", "MM"
    )


class _MountOptions(Options, group="a mount of your own"):
    bolt_circle_mm: float | None = option(
        None, "a plate with holes on a circle of this diameter", "MM"
    )
    bolts: int | None = option(
        None, "number of holes in it (default: 4)", "N", needs="bolt_circle_mm"
    )
    screw: str | None = option(
        None,
        "screws for the holes (default: M6)",
        choices=printables.SCREWS,
        needs="bolt_circle_mm",
    )
    grip_mm: tuple[float, float, float] | None = option(
        None,
        "a block for a gripper: between its fingers, along their width, along their length; "
        "the ball's place then counts from the fingertips",
        ("WIDTH", "DEPTH", "LENGTH"),
    )


class _PrintPartsOptions(_BaseOptions, _BallOptions, _MountOptions, OutputOptions):
    out: Path = option(..., "folder to write to", "DIR")
    mount: Sequence[str] | None = option(
        None,
        "what holds the ball at the arm: a robot's name, a code of ISO 9409-1 as iso-63-4-m6, "
        "or one of the list below (default: all of that)",
        "NAME",
    )
    format: Sequence[str] = option(
        ("stl", "3mf", "svg"),
        "formats of the files (default: stl 3mf svg, a drawing); step needs mukca[step]",
        choices=printables.FORMATS,
    )
    author: str = option("mukca", "the author's name in 3MF files", "NAME")


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
    if options.grip_mm is not None:
        mounts["gripper"] = printables.grip(*options.grip_mm)
    if "none" in (names := options.mount or ()) and (mounts or len(names) > 1):
        raise printables.PrintableError("--mount none stands alone")
    mounts = {
        name: printables.find_mount(name) for name in names if name != "none"
    } | mounts
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
