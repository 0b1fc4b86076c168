"""``mukca command`` and ``mukca poses``: joint positions for poses of the true tool, and back."""

import csv
import io
import re
import sys
import warnings
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from .... import recorder
from ....errors import ON_FLANGE, MukcaError
from ....recorder import POSE_FORMS, RecordingError
from ....solver import calibration, results
from ....solver.assessment import plural
from ....solver.calibration import UsageError
from .. import JsonOption, PayloadOptions, Terminal, one_arm, warn_of_use
from .tool import numbers

if TYPE_CHECKING:
    import numpy as np

    from ....recorder import Rows
    from ....solver.calibration import Setup

PLACE, QUATERNION = ("x", "y", "z"), ("qx", "qy", "qz", "qw")
FORMS = (PLACE, (*PLACE, *QUATERNION), (*PLACE, "roll", "pitch", "yaw"))
DEVIATIONS = tuple(f"{axis}_deviation" for axis in ("x", "y", "z", "rx", "ry", "rz"))
INPUT = "standard input"
ROW = r"^(?:joint positions: )?(?:row|pose) (\d+)[,:] "


class _PathOptions(PayloadOptions, JsonOption):
    tool: str | None = None
    out: Path | None = None
    force: bool = False

    def setup(self) -> "Setup":
        """Return the tool and the payload on the arm."""
        tool = self.tool
        if tool and "," in tool:
            try:
                pose = calibration.pose_of_numbers(list(map(float, tool.split(","))))
                tool = calibration.one_pose(pose, "pose", ON_FLANGE)
            except ValueError:
                raise UsageError(
                    f"--tool {self.tool}: give x,y,z,roll,pitch,yaw"
                ) from None
            except MukcaError as error:
                raise UsageError(f"--tool {self.tool}: {error}") from None
        return {"tool": tool, "payload": self.carried}


class _CommandOptions(_PathOptions):
    calibration: Path
    poses: Path
    start: Sequence[float] | None = None
    prefer: Sequence[float] | None = None


def run_command(options: _CommandOptions, terminal: Terminal) -> int:
    """Write the joint positions, each row near the one before."""
    import numpy as np

    from ....solver.calibration import find_jumps, pose_of_numbers

    calibrated = calibration.load_calibration(one_arm(options.calibration))
    setup = options.setup()
    start, prefer = options.start, options.prefer
    before = None
    names = calibrated.robot.joint_names
    with written(options, terminal, names, options.poses, calibrated) as write:
        for rows, wheres in streamed(options.poses, (), POSE_FORMS, terminal):
            with located(wheres, terminal):
                points = rows.shape[1] == 3
                poses = rows if points else pose_of_numbers(rows)
                path = calibrated.command_path(poses, start, prefer, **setup)
                if before:
                    step = np.stack([before, path.positions[0]])
                    flange = calibrated.kinematics(**setup).flange
                    if find_jumps(step, flange, not points):
                        path = replace(path, jumps=(0, *path.jumps))
                result = path.checked()
            write(*result)
            if prefer is None:
                prefer = result[0].tolist() if start is None else start
            start = before = result[-1].tolist()
    return 0


def streamed(
    file: Path,
    joint_names: Sequence[str],
    forms: Sequence[Sequence[str]],
    terminal: Terminal,
) -> "Iterator[tuple[np.ndarray, list[str]]]":
    """Yield the rows of a file; those of standard input, which is called -, one by one."""
    import numpy as np

    if str(file) != "-":
        rows = recorder.read_rows(file, joint_names, forms)
        terminal.warn(*rows.notes)
        yield np.array(_posed(rows)), rows.wheres
        return
    before: tuple[str, ...] = ()
    for where, rows in _typed(joint_names, forms):
        terminal.warn(*(note for note in rows.notes if note not in before))
        before = rows.notes
        yield np.array(_posed(rows)), [where]


def _typed(
    joint_names: Sequence[str], forms: Sequence[Sequence[str]]
) -> "Iterator[tuple[str, Rows]]":
    """Yield the rows of standard input, each below the header that came first."""
    head = ""
    count = 0
    for number, line in enumerate(sys.stdin, 1):
        where = f"{INPUT}:{number}"
        try:
            table = recorder.foreign_table(head + line, Path(INPUT), joint_names)
            rows = recorder.rows_of(table, joint_names, forms)
        except recorder.EmptyRecordingError:
            head += line
            continue
        except RecordingError as error:
            if not count:
                raise
            raise UsageError(
                f"{where}: {count} numbers are needed: {line.strip()!r}"
            ) from error
        count = len(rows.numbers[0])
        yield where, rows


def _posed(rows: "Rows") -> list[tuple[float, ...]]:
    """Return rows of poses as x y z with roll pitch yaw or a quaternion."""
    if rows.form in FORMS or not rows.form:
        return rows.numbers
    return [
        (*row[:3], *recorder.unit_quaternion(row[3:], rows.form[3:], where))
        for row, where in zip(rows.numbers, rows.wheres, strict=True)
    ]


@contextmanager
def located(wheres: Sequence[str], terminal: Terminal) -> Generator[None]:
    """Name file and line where an error or a warning has the number of a row."""

    def line(message: object) -> str:
        return re.sub(ROW, lambda row: f"{wheres[int(row[1])]}: ", str(message))

    with warnings.catch_warnings(record=True) as messages:
        warnings.simplefilter("always")
        try:
            yield
        except MukcaError as error:
            raise MukcaError(line(error)) from None
    terminal.warn(*(line(message.message) for message in messages))


@contextmanager
def written(
    options: _PathOptions,
    terminal: Terminal,
    header: Sequence[str],
    source: Path,
    calibrated: calibration.Calibration,
) -> "Generator[Callable[..., None]]":
    """Yield a function that writes rows as CSV, each number so that it reads back exactly.

    A file appears whole or not at all; on standard output rows appear at once, and before the
    first the header, so that a program can write a pose to the one end and read at the other.
    JSON has them all at the end.
    """
    out = None if str(options.out) == "-" else options.out
    if out:
        results.refuse_existing(out.parent, [out.name], force=options.force)
    head = io.StringIO()
    csv.writer(head, lineterminator="").writerow(header)
    lines = [head.getvalue()]
    values: list[list[float]] = []

    def write(*rows: "np.ndarray") -> None:
        lines.extend(",".join(map(repr, row.tolist())) for row in rows)
        if terminal.json:
            values.extend(row.tolist() for row in rows)
        elif out is None:
            Terminal().say(*lines)  # what was asked for, however quiet the terminal is
            lines.clear()

    if str(source) == "-":
        write()
    yield write
    if out:
        results.write_files(out.parent, {out.name: ("\n".join(lines) + "\n").encode()})
        terminal.say(f"Wrote {plural(len(lines) - 1, 'row')} to {out}")
    outputs = [str(out)] if out else []
    terminal.emit({"columns": [*header], "rows": values, "outputs": outputs})
    if str(source) != "-":  # a program reads what a stream says
        warn_of_use(calibrated, terminal)


class _PosesOptions(_PathOptions):
    calibration: Path
    joints: Path
    deviation: bool = False
    relative_to: str = ""


def run_poses(options: _PosesOptions, terminal: Terminal) -> int:
    """Write the pose of the tool for each row, as place and quaternion, and its deviation."""
    import numpy as np

    calibrated = calibration.load_calibration(one_arm(options.calibration))
    setup = options.setup()
    joints = len(calibrated.robot.joint_names)
    start = numbers(options.relative_to, "--relative-to", (joints,)) or None
    header = (*FORMS[1], *DEVIATIONS) if options.deviation else FORMS[1]
    with written(options, terminal, header, options.joints, calibrated) as write:
        for q, wheres in streamed(
            options.joints, calibrated.robot.joint_names, ((),), terminal
        ):
            with located(wheres, terminal):
                T = calibrated.flange(q, **setup)
                columns = [T[:, :3, 3], calibration.quaternion_of(T[:, :3, :3])]
                if options.deviation:
                    covariances = calibrated.deviation(q, relative_to=start, **setup)
                    columns.append(np.sqrt(np.diagonal(covariances, axis1=1, axis2=2)))
            write(*np.hstack(columns))
    return 0
