"""``mukca command`` and ``mukca poses``: joint positions for poses of the true tool, and back."""

import re
import sys
import warnings
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from ....errors import MukcaError
from ....solver import calibration
from ....solver.calibration import UsageError
from .. import PayloadOptions, Terminal, argument, one_arm, option

if TYPE_CHECKING:
    import numpy as np

    from ....solver.calibration import Setup

PLACE, QUATERNION = ("x", "y", "z"), ("qx", "qy", "qz", "qw")
FORMS = (PLACE, (*PLACE, *QUATERNION), (*PLACE, "roll", "pitch", "yaw"))
INPUT = "standard input"
ROW = r"^(?:joint positions: )?(?:row|pose) (\d+)[,:] "


class _PathOptions(PayloadOptions):
    tool: str | None = None
    out: Path | None = None
    force: bool = option(False, needs="out")

    def setup(self) -> "Setup":
        """Return the tool and the payload on the arm."""
        from ....solver.calibration import pose_of_numbers

        tool = self.tool
        if tool is not None and "," in tool:
            try:
                tool = pose_of_numbers([float(word) for word in tool.split(",")])
            except ValueError:
                raise UsageError(f"--tool {self.tool}: give x,y,z,roll,pitch,yaw") from None
        return {"tool": tool, "payload": self.carried}


class _CommandOptions(_PathOptions):
    calibration: Path = argument()
    poses: Path = argument()
    start: Sequence[float] | None = None
    prefer: Sequence[float] | None = None


def run_command(options: _CommandOptions, terminal: Terminal) -> int:
    """Write the joint positions, each row near the one before."""
    import numpy as np

    from ....solver.calibration import find_jumps, load_calibration, pose_of_numbers

    calibration, setup = load_calibration(one_arm(options.calibration)), options.setup()
    near, prefer, before = options.start, options.prefer, None
    names = calibration.robot.joint_names
    with written(options, terminal, names, options.poses) as write:
        for rows, wheres in streamed(options.poses, FORMS):
            with located(wheres, terminal):
                points = rows.shape[1] == 3
                poses = rows if points else pose_of_numbers(rows)
                path = calibration.command_path(poses, near, prefer, **setup)
                if before is not None:
                    step = np.stack([before, path.positions[0]])
                    if find_jumps(step, calibration.kinematics(**setup).flange, not points):
                        path = replace(path, jumps=(0, *path.jumps))
                found = path.checked()
            write(*found)
            if prefer is None:
                prefer = found[0].tolist() if near is None else near
            near = before = found[-1].tolist()
    return 0


def read_rows(file: Path, forms: Sequence[Sequence[str]]) -> "tuple[np.ndarray, list[str]]":
    """Return the numbers of a CSV file in the order of one of some headers, and their lines."""
    import numpy as np

    from ....recorder import read_table

    try:
        table = read_table(file)
    except MukcaError:
        if file.is_file() and "," in (line := file.read_text(errors="replace").partition("\n")[0]):
            _order(file, line.split(","), forms)  # its header says more than its first cell
        raise
    order = _order(file, table.header or (), forms)
    return np.array(table.rows)[:, order], [f"{file}:{line}" for line in table.lines]


def streamed(
    file: Path, forms: Sequence[Sequence[str]]
) -> "Iterator[tuple[np.ndarray, list[str]]]":
    """Yield a file as by :func:`read_rows`; standard input, which is called -, row by row."""
    import numpy as np

    if str(file) != "-":
        yield read_rows(file, forms)
        return
    order: list[int] = []
    for number, line in enumerate(sys.stdin, 1):
        where, cells = f"{INPUT}:{number}", [cell.strip() for cell in line.split(",")]
        if not order:
            order = _order(INPUT, cells, forms)
            continue
        try:
            row = [float(cells[i]) for i in order]
        except (ValueError, IndexError):
            row = []
        if len(row) != len(cells):
            raise UsageError(f"{where}: {len(order)} numbers are needed: {line.strip()!r}")
        yield np.array([row]), [where]


def _order(name: Path | str, header: Sequence[str], forms: Sequence[Sequence[str]]) -> list[int]:
    """Return where the columns of one of some headers stand in a file's."""
    form = next((form for form in forms if sorted(form) == sorted(header)), None)
    if form is None:
        known = "; or ".join(",".join(form) for form in forms)
        given = ",".join(header) or "missing"
        raise UsageError(f"{name}: its header is {given:.60}; needed: {known}")
    return [header.index(word) for word in form]


@contextmanager
def located(wheres: Sequence[str], terminal: Terminal) -> Generator[None]:
    """Name file and line where an error or a warning has the number of a row."""

    def line(message: object) -> str:
        return re.sub(ROW, lambda row: f"{wheres[int(row[1])]}: ", str(message))

    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        try:
            yield
        except MukcaError as error:
            raise MukcaError(line(error)) from None
    terminal.warn(*(line(one.message) for one in said))


@contextmanager
def written(
    options: _PathOptions, terminal: Terminal, header: Sequence[str], source: Path
) -> "Generator[Callable[..., None]]":
    """Yield a function that writes rows as CSV, each number so that it reads back exactly.

    A file appears whole or not at all; on standard output rows appear at once, and before the
    first the header, so that a program can write a pose to the one end and read at the other.
    """
    from ....solver.results import refuse_existing, write_files

    out = None if str(options.out) == "-" else options.out
    if out is not None:
        refuse_existing(out.parent, [out.name], force=options.force)
    lines = [",".join(header)]

    def write(*rows: "np.ndarray") -> None:
        lines.extend(",".join(map(repr, row.tolist())) for row in rows)
        if out is None:
            terminal.say(*lines)
            sys.stdout.flush()
            lines.clear()

    if str(source) == "-":
        write()
    yield write
    if out is not None:
        write_files(out.parent, {out.name: ("\n".join(lines) + "\n").encode()})
        terminal.say(f"Wrote {len(lines) - 1} rows to {out}")


class _PosesOptions(_PathOptions):
    calibration: Path = argument()
    joints: Path = argument()


def run_poses(options: _PosesOptions, terminal: Terminal) -> int:
    """Write the pose of the tool for each row, as place and quaternion."""
    import numpy as np

    held, setup = calibration.load_calibration(one_arm(options.calibration)), options.setup()
    with written(options, terminal, FORMS[1], options.joints) as write:
        for q, wheres in streamed(options.joints, [held.robot.joint_names]):
            with located(wheres, terminal):
                T = held.flange(q, **setup)
            write(*np.hstack([T[:, :3, 3], calibration.quaternion_of(T[:, :3, :3])]))
    return 0
