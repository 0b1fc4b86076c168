"""``mukca tool``, ``rezero`` and ``handeye``: one thing found, the calibrated arm held."""

import math
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Literal

from .... import recorder
from ....errors import JOINT_POSITION, LENGTH
from ....solver import calibration, partial
from ....solver.calibration import UsageError
from ....solver.identification import robot
from ....solver.results import refuse_existing, write_files
from ... import cameras, export
from .. import DetailsOptions, Terminal, one_arm
from .report import emit_with_page

_LIMIT = 2.0
BELOW = 5
"""Lines of the screen below the answer: what was written, and what to do with it."""


class _ToolOptions(DetailsOptions):
    calibration: Path
    data: Sequence[Path]
    name: str = "tool"
    axis: Sequence[Path] = ()
    face: tuple[Path, Path] | None = None
    stood: str = ""
    limit_mm: float = _LIMIT


def run_tool(options: _ToolOptions, terminal: Terminal) -> int:
    """Print the tool's place, and write the calibration with its link."""
    options.check_out()
    calibrated = calibration.load_calibration(one_arm(options.calibration))
    arm = calibrated.robot
    face = None
    if options.face:
        (first,), (second,) = (touches([file], arm) for file in options.face)
        face = first, second
    tool = partial.tool(
        calibrated,
        touches(options.data, arm),
        options.name,
        axis=touches(options.axis, arm) if options.axis else (),
        face=face,
        stood=options.stood,
        limit=_limit(options.limit_mm),
    )
    finish(tool, options, terminal)
    return 3 if tool.untold else 0


def _limit(millimetres: float) -> float:
    """Return the largest standard deviation of a place that is enough [m]."""
    if not 0 < millimetres < math.inf:
        raise UsageError(f"--limit-mm {millimetres:g}: give millimetres above 0")
    return 1e-3 * millimetres


def finish(
    result: "partial.CameraPose | partial.Tool | partial.Zeros",
    options: DetailsOptions,
    terminal: Terminal,
) -> None:
    """Print the estimate, write it if --out is given, and emit it."""
    if options.details:
        terminal.say(*result.text)
    else:
        terminal.say_in_short(*result.brief, below=BELOW)
    if options.out is None and getattr(result, "decided", True):
        terminal.say(
            "Nothing was written; add --out DIR for a calibration and a URDF with this result."
        )
    emit_with_page(options, terminal, result.text, result.as_dict(), result.save)


def touches(files: Sequence[Path], arm: "robot.Robot") -> "list[recorder.Placement]":
    """Return placements by their folders; a CSV file's points are its sockets."""
    placements: list[recorder.Placement] = []
    for file in files:
        if not file.is_file() or file.name == recorder.SAMPLES:
            placements += recorder.read_placements(file)
            continue
        if file.suffix != ".csv":
            raise UsageError(
                f"{file}: give a placement's folder, or a CSV file with a column for each joint"
            )
        names = arm.joint_names
        rows = recorder.read_rows(file, names, [("x", "y", "z"), ("point",), ()])
        m = len(names)
        samples = list[recorder.Sample]()
        for row, where in zip(rows.numbers, rows.wheres, strict=True):
            q = row[:m]
            columns = row[m:]
            point = (columns[0], columns[1], columns[2]) if len(columns) == 3 else None
            socket = 0 if point else int(sum(columns))
            if doubt := LENGTH.doubt(point or ()):
                raise UsageError(
                    f"{where}: x, y or z is {doubt} A header of x [mm] is read as such"
                )
            samples.append(recorder.Sample(q, socket, where=where, point=point))
        placement = recorder.Placement(file.stem, tuple(samples), names, files=(file,))
        placements.append(replace(placement, remarks=rows.notes))
    return placements


class _RezeroOptions(DetailsOptions):
    calibration: Path
    data: Sequence[Path]
    joint: Sequence[str] = ()
    stood: str = ""
    ball_moved: bool = False
    distance: float | None = None
    stops: bool = False
    like: Path | None = None
    servos: Literal["feetech", "dynamixel"] | None = None


def run_rezero(options: _RezeroOptions, terminal: Terminal) -> int:
    """Print each joint's zero, and write the calibration with the new ones."""
    if options.stops:
        return _zeros_by_stops(options, terminal)
    options.check_out()
    zeros = partial.rezero(
        arm_of(options.calibration),
        recorder.read_placements(*options.data),
        options.joint,
        options.stood,
        ball_moved=options.ball_moved,
        distance=options.distance,
    )
    finish(zeros, options, terminal)
    if options.out and zeros.changed:
        terminal.say(
            "Set the zeros in the robot instead, or load these: one of both, never both."
        )
    identified = {joint.joint for joint in zeros.joints if joint.told}
    complete = identified and identified.issuperset(options.joint)
    return 0 if complete and zeros.decided and not zeros.other else 3


def _zeros_by_stops(options: _RezeroOptions, terminal: Terminal) -> int:
    """Print each joint's zero by its stops, and write lerobot's file with the new ones."""
    single = len(options.data) == 1
    if not single or (options.out and not (options.like and options.servos)):
        raise UsageError(
            "rezero --stops: give one folder of mukca record --stops; --out needs --like FILE and "
            "--servos feetech or dynamixel"
        )
    file = options.calibration
    before = recorder.read_stops(file.parent if file.is_file() else file)
    after = recorder.read_stops(options.data[0])
    zeros = partial.zeros_by_stops(before.ranges, after.ranges, after.wrapped)
    terminal.say(*zeros.text)
    outputs = dict[str, str]()
    if options.out and options.like and options.servos:
        if "signs=" in after.driver:
            raise UsageError(
                f"{after.driver}: read with signs=.., which lerobot does not know; shift the zeros "
                "by hand"
            )
        ticks = {zero.joint: zero.counts for zero in zeros.changed}
        joints = tuple(before.ranges)
        data = export.with_zeros(options.like, options.servos, joints, ticks)
        files = {options.out.name: data}
        refuse_existing(options.out.parent, files, force=options.force)
        written = write_files(options.out.parent, files)
        outputs = {name: str(path) for name, path in written.items()}
        terminal.say(*(f"Wrote {path}" for path in outputs.values()))
    rows = [asdict(zero) for zero in zeros.joints]
    terminal.emit({"zeros": rows, "untold": zeros.untold, "outputs": outputs})
    return 0 if zeros.joints else 3


def arm_of(file: Path) -> "calibration.Calibration | robot.Robot":
    """Return a calibration by its file or folder, or a nominal robot by its name or URDF."""
    if str(file) in robot.shipped_robots() or robot.urdf_of(str(file)).endswith(
        ".urdf"
    ):
        return robot.load_robot(file)
    return calibration.load_calibration(one_arm(file))


POSES = "poses.csv"
_BOARD = (9.0, 6.0, 30.0, 21.0)
_MARKERS = "5X5_100"


class _HandeyeOptions(DetailsOptions):
    calibration: Path
    data: Sequence[Path]
    camera: "partial.Camera"
    name: str = "camera"
    scale: "partial.Scale" = "board"
    near: str = ""
    board: tuple[float, float, float, float] = _BOARD
    dictionary: str = _MARKERS
    intrinsics: str = ""
    limit_mm: float = _LIMIT


def run_handeye(options: _HandeyeOptions, terminal: Terminal) -> int:
    """Print the camera's pose, and write the calibration with its link."""
    options.check_out()
    settings = (options.board, options.dictionary, options.intrinsics)
    images = [path for path in options.data if (path / cameras.JOINTS).is_file()]
    if settings != (_BOARD, _MARKERS, "") and not images:
        raise UsageError(
            "--board, --dictionary and --intrinsics are for folders of images"
        )
    calibrated = calibration.load_calibration(one_arm(options.calibration))
    joints = len(calibrated.robot.joint_names)
    start = numbers(options.near, "--near", (joints,)) or None
    doubt = JOINT_POSITION.doubt(start or ())
    if doubt:
        raise UsageError(f"--near {options.near}: {doubt}")
    views: list[recorder.Placement] = []
    for path in options.data:
        for view in _views(path, options, calibrated):
            views.append(cameras.joints_of(calibrated, view, start, options.camera))
    pose = partial.handeye(
        calibrated,
        views,
        options.camera,
        options.name,
        limit=_limit(options.limit_mm),
        scale=options.scale,
    )
    finish(pose, options, terminal)
    return 3 if pose.untold else 0


def _views(
    path: Path, options: _HandeyeOptions, calibrated: "calibration.Calibration"
) -> "list[recorder.Placement]":
    """Return the views of a CSV file of any name, of a folder of images, or of placements."""
    if path.is_dir() and (path / POSES).is_file():
        path = path / POSES
    if path.suffix == ".csv" and path.is_file() and path.name != recorder.SAMPLES:
        return [replace(recorder.read_table_placement(path), name=path.stem)]
    if not (path / cameras.JOINTS).is_file():
        return recorder.read_placements(path)
    columns, rows, square, marker = options.board
    sizes = int(columns), int(rows), square / 1e3, marker / 1e3
    board = cameras.Board(*sizes, options.dictionary)
    camera = numbers(options.intrinsics, "--intrinsics", (4, 8, 9))
    views = cameras.read_images(path, board, camera)
    return [cameras.turned_alike(calibrated, views, board)]


def numbers(words: str, flag: str, counts: Sequence[int]) -> list[float]:
    """Return numbers between commas; none for an empty word."""
    try:
        values = [float(word) for word in words.split(",") if word.strip()]
    except ValueError:
        values = [float("nan")]
    if words and (len(values) not in counts or not all(map(math.isfinite, values))):
        known = " or ".join(map(str, counts))
        raise UsageError(f"{flag} {words}: give {known} numbers between commas")
    return values
