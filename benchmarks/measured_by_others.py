"""Write docs/measured_by_others.md: arms that others measured, each by one command.

    python benchmarks/measured_by_others.py TRACKER [--records NAME ...]

TRACKER has a folder for each record, as their owners published them. A record of one table is held
out by every third row. A row that is not measured anew stays as the page has it. Another record is
one more entry of RECORDS.
"""

import argparse
import json
import shlex
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from datetime import date
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from mukca.tools.cli import main as mukca

PAGE = Path(__file__).parents[1] / "docs" / "measured_by_others.md"
HEAD = """# Measured by others

Public records of arms that nobody here has measured, each taken in by one command. Errors are true
ones at points that no fit has seen, in mm, in the mean: of the nominal model with frame and ball
refitted, of the calibrated URDF alone, and of the full model, which corrects joints. `source` is
the figure that the owners of the record state for their own calibration. `target` is what the full
model should leave. `python benchmarks/measured_by_others.py TRACKER` writes this page.

| record | held out | nominal | URDF | full | target | source | verdict | measured |
|---|---|---|---|---|---|---|---|---|
"""
_GITHUB = "https://github.com"


@dataclass(frozen=True)
class Record:
    """What others measured, and the command that takes it in."""

    title: str
    source: str
    """Where it is, below GitHub."""
    words: str
    """Of ``mukca solve``, within the folder of records."""
    published: str
    """The owners' own figure, in words."""
    target: float
    """Mean error that the full model should leave [mm]."""


RECORDS = {
    "ur5": Record(
        "Universal Robots UR5, laser tracker",
        "pauljac7700/serial_robots_datasets",
        "ur5/points.csv --robot ur5.urdf --flange tool0 --ball 0 0 0.031",
        "0.155, with a neural network",
        0.060,
    ),
    "ur10": Record(
        "Universal Robots UR10, 6-D probe",
        "christianlandgraf/ipa-robot-accuracy",
        "ur10/points.csv --robot ur10",
        "none in its README",
        0.089,
    ),
    "irb120": Record(
        "ABB IRB 120, laser tracker",
        "icelinker/Robot-Calibration-LaserTracker",
        "irb120/train --test irb120/test --robot irb120/irb120.urdf --flange tool0 "
        "--ball 0 0 0.1",
        "none in its README",
        0.340,
    ),
    "iiwa7": Record(
        "KUKA LBR iiwa 7, not named",
        "Zhangzhongqiu/robot-calibration",
        "iiwa7/train --test iiwa7/test --robot iiwa7",
        "none in its README",
        0.242,
    ),
    "ctu": Record(
        "Motoman MA1400, a cube, laser tracker",
        "ctu-vras/multirobot-calibration",
        "ctu/cube_right/train --test ctu/cube_right/test --robot ctu/right.urdf --flange tool0 "
        "--ball 0.045 0 0.245",
        "none in its README",
        0.058,
    ),
    "tiago_pro": Record(
        "PAL TIAGo Pro, motion capture",
        "thanhndv212/figaroh-examples",
        "tiago_pro/poses.csv --robot tiago_pro/tiago_pro_right.urdf "
        "--flange pal_atc_base_link --ball 0 0 0.142 --flange-poses",
        "21.2 rms at 12 poses",
        3.5,
    ),
}


def halves(file: Path, folder: Path) -> tuple[Path, Path]:
    """Return two folders of a table's rows: two of three to train on, each third one held out."""
    text = file.read_text().splitlines()
    size = 1 + sum(line.startswith("#") for line in text)
    head, rows = text[:size], text[size:]
    parts = {
        "train": [row for i, row in enumerate(rows) if i % 3],
        "test": rows[::3],
    }
    for name, some in parts.items():
        (folder / name).mkdir()
        (folder / name / file.name).write_text("\n".join([*head, *some, ""]))
    return folder / "train", folder / "test"


def solved(words: list[str], tracker: Path) -> Any:
    """Return what ``mukca solve`` says of a record, and what it refuses as an error."""
    files = [str(tracker / w) if "/" in w or ".urdf" in w else w for w in words]
    with TemporaryDirectory() as folder, redirect_stdout(StringIO()) as text:
        if "--test" not in words:
            train, test = halves(Path(files[0]), Path(folder))
            files[:1] = [str(train), "--test", str(test)]
        with redirect_stderr(StringIO()) as told:
            mukca(["solve", *files, "--json"])
    if not text.getvalue():
        raise SystemExit(told.getvalue())
    return json.loads(text.getvalue())


def row(name: str, tracker: Path) -> str:
    """Return a record's row of the table."""
    record = RECORDS[name]
    answer: dict[str, Any] = solved(shlex.split(record.words), tracker)
    (test,) = (part for part in answer["placements"] if part["role"] == "test")
    models = ("ball_refitted", "geometric", "calibrated")
    errors = [test[model] or test["calibrated"] for model in models]
    cells = [
        f"[{record.title}]({_GITHUB}/{record.source})",
        str(sum(test["samples"])),
        *(f"{1e3 * error['mean_absolute_error']:.3f}" for error in errors),
        f"{record.target:.3f}",
        record.published,
        answer["verdict"]["title"],
        date.today().isoformat(),
    ]
    return f"| {' | '.join(cells)} |"


def kept_rows() -> dict[str, str]:
    """Return the rows that the page has."""
    lines = PAGE.read_text().splitlines() if PAGE.exists() else []
    links = {name: f"]({_GITHUB}/{r.source})" for name, r in RECORDS.items()}
    return {name: ln for name, link in links.items() for ln in lines if link in ln}


def page(rows: dict[str, str]) -> str:
    """Return the page: the table, then the commands."""
    table = "\n".join(rows[name] for name in RECORDS if name in rows)
    commands = "\n".join(f"mukca solve {r.words}" for r in RECORDS.values())
    return (
        f"{HEAD}{table}\n\nThe commands, in the folder of the records; of those without `--test`, "
        f"every third row is held out:\n\n```\n{commands}\n```\n"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tracker", type=Path, help="folder with the records' folders")
    parser.add_argument(
        "--records", nargs="+", choices=list(RECORDS), default=list(RECORDS)
    )
    arguments = parser.parse_args()
    rows = kept_rows()
    for name in arguments.records:
        if not (arguments.tracker / name).exists():
            print(f"{name}: not in {arguments.tracker}, left out")
            continue
        rows[name] = row(name, arguments.tracker)
        print(rows[name], flush=True)
    PAGE.write_text(page(rows))


if __name__ == "__main__":
    main()
