"""``mukca extract``: find the rests of an arm in a log, and make a recording of them."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from ....errors import fixed
from ....recorder import metadata_file
from ....recorder.stream import STILL, WINDOW
from ....solver.identification.robot import Robot
from ....solver.results import write_files
from ... import cli, extract
from ...recording import joints_of
from .convert import refuse_another_form

NOT_ENOUGH = 3
NO_RESTS = (
    "No rest was seen: the arm must stand still for two windows of {:.2g} s (--window)."
)
NO_SAMPLES = (
    "No rest is a sample, so there is nothing to write: 4 and more of one socket lie together; "
    "--assign front:0=1-30 says which rests were samples."
)

NOTHING_WRITTEN = "Nothing was written; --out DIR writes a folder for each placement."
LOOK = (
    "Look at the picture: only you know whether the ball sat in a socket at each rest."
)


class _ExtractOptions(cli.RobotOptions, cli.OutputOptions):
    log: Path
    distance: float = 0.05
    assign: Sequence[str] = ()
    topic: str | None = None
    joints: str | None = None
    units: str | None = None
    efforts: bool = False
    window: float = WINDOW
    still: float | None = None
    out: Path | None = None


def run_extract(options: _ExtractOptions, terminal: cli.Terminal) -> int:
    """Find the rests, show which samples they may be, and write them."""
    options.check_out()
    robot = options.load_robot()
    log, search = _find_rests(options, robot, terminal)
    terminal.say(*log.notes)
    terminal.warn(*(_left_out(stretch, log) for stretch in search.lost))
    joints = joints_of(robot)
    rests = extract.propose_samples(robot, search.rests, joints, options.distance)
    if options.assign:
        rests = extract.assign(rests, options.assign)
    if rests:
        _show(rests, log, terminal)
    folders = extract.placements_of(rests, robot.joint_names, options.distance)
    outputs: dict[str, str] = {}
    if options.out and folders:
        metadata = {
            "robot": robot.name,
            "joints": list(robot.joint_names),
            "units": [joint.unit for joint in joints],
            "distance": options.distance,
            "sockets": 2,
            "model_sha256": robot.sha256,
            "sessions": [
                {
                    "extracted_from": str(options.log),
                    "window": search.window,
                    "still": search.still,
                }
            ],
        }
        picture = extract.rests_picture(log, robot.joint_names, rests)
        outputs = _write(options.out, folders, metadata, picture)
    if not rests:
        terminal.say(NO_RESTS.format(search.window))
    elif not folders:
        terminal.say(NO_SAMPLES)
    elif not outputs:
        terminal.say(NOTHING_WRITTEN)
    terminal.say(*(f"Wrote {path}" for path in outputs.values()))
    if outputs:
        terminal.say(LOOK, f"Next: mukca check {options.out} --robot {options.robot}")
    left_out = [{"begin": s.begin, "end": s.end, "why": s.why} for s in search.lost]
    rows = [_row(pause, log) for pause in rests]
    document = {"robot": options.robot, "rests": rows, "outputs": outputs}
    terminal.emit({**document, "left_out": left_out})
    if not folders:
        return NOT_ENOUGH
    return 1 if search.lost else 0


class _Search(NamedTuple):
    """Outcome of the search for rests in a log."""

    rests: "list[extract.Rest]"
    lost: "list[extract.Stretch]"
    """Stretches of the log that are unsound, and last."""
    window: float
    """Length of the average that makes a sample [s]."""
    still: float
    """Largest standard deviation of a joint at rest [rad]."""


def _find_rests(
    options: _ExtractOptions, robot: Robot, terminal: cli.Terminal
) -> "tuple[extract.Log, _Search]":
    """Read the log, and find the rests of the arm in it."""
    joints = joints_of(robot)
    question = extract.Question(
        options.log,
        robot.joint_names,
        tuple(joint.prismatic for joint in joints),
        options.joints,
        options.topic,
        options.units,
        options.efforts,
    )
    with terminal.progress() as step:
        step(f"reading {options.log}")
        log = extract.read_log(question)
        window = max(options.window, log.least_window)
        still = max(STILL, log.resolution) if options.still is None else options.still
        step(f"looking for rests in {len(log.stamps)} states")
        stretches: list[extract.Stretch] = []
        rests = extract.find_rests(
            log, joints, window=window, still=still, unsound=stretches
        )
    lost = [stretch for stretch in stretches if stretch.lasts]
    return log, _Search(rests, lost, window, still)


def _write(
    out: Path,
    folders: dict[str, dict[str, bytes]],
    metadata: dict[str, Any],
    picture: bytes,
) -> dict[str, str]:
    """Write placements into their folders, and the picture; return the paths by name."""
    contents: dict[str, bytes] = {}
    for name, samples in folders.items():
        refuse_another_form(out / name, samples)
        files = samples | metadata_file(metadata)
        contents |= {f"{name}/{file}": content for file, content in files.items()}
    write_files(out, contents | {"rests.svg": picture})
    paths = {name: str(out / name) for name in folders}
    return {**paths, "picture": str(out / "rests.svg")}


def _left_out(stretch: "extract.Stretch", log: "extract.Log") -> str:
    of_episode = f" of episode {stretch.part}" * log.episodes
    # Episodes have clocks of their own.
    first = (log.parts == stretch.part).argmax() if log.episodes else 0
    start = float(log.stamps[first])
    return (
        f"{stretch.begin - start:.1f} to {stretch.end - start:.1f} s after the first state"
        f"{of_episode} are left out: {stretch.why}"
    )


def _show(
    rests: "Sequence[extract.Rest]", log: "extract.Log", terminal: cli.Terminal
) -> None:
    heads = (
        "rest",
        *(["episode"] * log.episodes),
        "from s",
        "for s",
        "ball by the nominal model, mm",
        "spread mrad",
        "sample of",
    )
    rows: list[list[str]] = []
    start = min(pause.begin for pause in rests)
    for number, pause in enumerate(rests, start=1):
        ball = " ".join(f"{fixed(1e3 * value, 0):>7}" for value in pause.ball)
        sample = f"none: {pause.why}"
        if pause.placement:
            sample = f"{pause.placement}, socket {pause.socket}"
        row = [
            str(number),
            *([str(pause.part)] * log.episodes),
            f"{pause.begin - start:.1f}",
            f"{pause.end - pause.begin:.1f}",
            ball,
            f"{1e3 * max(pause.pose.spread):.3f}",
            sample,
        ]
        rows.append(row)
    terminal.tabulate("rests", heads, rows, left_columns=(len(heads) - 1,))


def _row(pause: "extract.Rest", log: "extract.Log") -> dict[str, Any]:
    return {
        "episode": pause.part if log.episodes else None,
        "begin": pause.begin,
        "end": pause.end,
        "position": list(pause.pose.position),
        "spread": list(pause.pose.spread),
        "ball": list(pause.ball),
        "placement": pause.placement,
        "socket": pause.socket if pause.placement else None,
        "why": pause.why,
    }
