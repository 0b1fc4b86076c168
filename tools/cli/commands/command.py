"""``mukca command``: joint positions at which the true tool stands at poses."""

import re
import warnings
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from ....errors import MukcaError
from ....solver.calibration import UsageError
from .. import PayloadOptions, Terminal, argument, one_arm, option

if TYPE_CHECKING:
    import numpy as np

    from ....solver.calibration import Setup

FORMS = (
    ("x", "y", "z"),
    ("x", "y", "z", "qx", "qy", "qz", "qw"),
    ("x", "y", "z", "roll", "pitch", "yaw"),
)
ROW = r"^(?:joint positions: )?(?:row|pose) (\d+)[,:] "


@dataclass(frozen=True, kw_only=True)
class PathOptions(PayloadOptions):
    """Options of what is on the arm, and of the file to write."""

    tool: str | None = option(
        "a link that stands still on the flange; or its place there in metres and turn in radians, "
        "as in 0,0,0.12,0,0,1.57 (default: the flange)",
        "TOOL",
    )
    out: Path | None = option("the CSV file to write (default: standard output)", "FILE")
    force: bool = option("overwrite it", default=False)

    def setup(self) -> "Setup":
        """Return what is on the arm."""
        from ....solver.calibration import pose_of_numbers

        tool = self.tool
        if tool is not None and "," in tool:
            try:
                tool = pose_of_numbers([float(word) for word in tool.split(",")])
            except ValueError:
                raise UsageError(f"--tool {self.tool}: give x,y,z,roll,pitch,yaw") from None
        return {"tool": tool, "payload": self.carried}


@dataclass(frozen=True, kw_only=True)
class Options(PathOptions):
    """Options of ``mukca command``."""

    calibration: Path = argument("calibration.json, or its folder", "CALIBRATION")
    poses: Path = argument("poses or points, one a line", "POSES.csv")
    start: Sequence[float] | None = option(
        "joint positions before the first pose (default: any that reach it)", "RAD"
    )
    prefer: Sequence[float] | None = option(
        "posture to stay near where a pose leaves a choice (default: the start)", "RAD"
    )


def run(options: Options, terminal: Terminal) -> int:
    """Write the joint positions, each row near the one before."""
    from ....solver.calibration import load_calibration, pose_of_numbers

    calibration, setup = load_calibration(one_arm(options.calibration)), options.setup()
    rows, wheres = read_rows(options.poses, FORMS)
    with located(wheres, terminal):
        poses = rows if rows.shape[1] == 3 else pose_of_numbers(rows)
        path = calibration.command_path(poses, options.start, options.prefer, **setup)
        found = path.checked()
    write_rows(options, terminal, path.joint_names, found)
    return 0


def read_rows(file: Path, forms: Sequence[Sequence[str]]) -> "tuple[np.ndarray, list[str]]":
    """Return the numbers of a CSV file in the order of one of some headers, and their lines."""
    import numpy as np

    from ....recorder import read_table

    table = read_table(file)
    header = table.header or ()
    form = next((form for form in forms if sorted(form) == sorted(header)), None)
    if form is None:
        known = "; or ".join(",".join(form) for form in forms)
        raise UsageError(f"{file}: its header is {','.join(header) or 'missing'}; needed: {known}")
    order = [header.index(name) for name in form]
    return np.array(table.rows)[:, order], [f"{file}:{line}" for line in table.lines]


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


def write_rows(
    options: PathOptions, terminal: Terminal, header: Sequence[str], rows: "np.ndarray"
) -> None:
    """Write a CSV file, each number so that it reads back exactly."""
    from ....solver.results import refuse_existing, write_files

    lines = [",".join(header), *(",".join(map(repr, row)) for row in rows.tolist())]
    if options.out is None:
        terminal.say("\n".join(lines))
        return
    refuse_existing(options.out.parent, [options.out.name], force=options.force)
    write_files(options.out.parent, {options.out.name: ("\n".join(lines) + "\n").encode()})
    terminal.say(f"Wrote {len(rows)} rows to {options.out}")
