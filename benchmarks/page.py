"""Write docs/benchmarks.md: accuracy, speed, trust and faults, dated, with the machine.

    python benchmarks/page.py [--measure accuracy instrument arms speed trust costs growth]
                              [--recordings DIR] [--tracker DIR]

What is named by --measure is measured anew, and kept in docs/benchmarks.json with the date and the
machine; all else stays as it was measured before. Then the page and its picture are written from
that file. The tables of README.md and docs/accuracy.md hold the same figures, as a test sees to.
"""

import argparse
import json
import os
import platform
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from datetime import date
from pathlib import Path
from statistics import fmean
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("MUKCA_CHECK_COVARIANCES", "1")

import mukca
from mukca.tools.report.plots import Axis, named_rows

ROOT = Path(__file__).parents[1]
FIGURES, PAGE = ROOT / "docs" / "benchmarks.json", ROOT / "docs" / "benchmarks.md"
BY_HAND = ROOT / "benchmarks" / "by_hand.md"
"""Figures of benchmarks that are run by hand, each with its command."""
PICTURE = ROOT / "docs" / "images" / "benchmarks.svg"
ARMS = {
    "Franka Panda": ("panda_3", "frontcenter"),
    "KUKA iiwa 14": ("kuka_14", "front"),
    "Kinova Gen3 lite": ("dinova_2", "front"),
}
"""Of the paper's recordings: the folder, and the placement that its Table I is trained on."""
COMMANDS = {
    "instrument": "instrument.py {tracker}/ur5 --robot {tracker}/ur5.urdf --flange tool0 "
    "--ball 0 0 0.031 --processes 1",
    "arms": "four_arms.py {tracker}",
    "speed": "solve.py",
    "trust": "verdicts.py --cases 40 --processes 1",
    "faults": "bad_inputs.py",
    "costs": "export_c.py",
    "growth": "growth.py",
}
"""Other benchmarks, whose words are kept."""
STYLE = """
svg { background: white; font: 12px sans-serif; }
.end { text-anchor: end; } .grid { stroke: #ddd; } .link { fill: #c9d0d8; }
.nominal { fill: #c4511d; } .paper { fill: #8a4fa3; }
.urdf { fill: #0b63a5; } .full { fill: #1b7f4b; }
"""


def mean_error(
    robot: mukca.Robot,
    train: Sequence[mukca.Placement],
    test: Sequence[mukca.Placement],
    method: str,
) -> tuple[float, float, float]:
    """Return errors [mm] by the nominal model, ball refitted, by the URDF and by the full model."""
    summary = mukca.calibrate(
        robot, train, test=test, method=method, as_recorded=True
    ).errors.summary
    found = summary.test or summary.train
    assert found is not None
    models = (found.before, found.loaded, found.calibrated)
    nominal, urdf, full = (1e3 * model.mean_absolute_error for model in models)
    return nominal, urdf, full


def accuracy(folders: Mapping[str, Path]) -> dict[str, Any]:
    """Return a row of the table for each arm, all in mm."""
    rows: dict[str, Any] = {}
    for arm, (name, trained) in ARMS.items():
        folder = folders["recordings"] / name
        robot = mukca.load_robot(folder / "nominal.urdf")
        every = mukca.read_placements(folder)
        is_trained = [p.path is not None and p.path.name == trained for p in every]
        one = [p for p, yes in zip(every, is_trained, strict=True) if yes]
        others = [p for p, yes in zip(every, is_trained, strict=True) if not yes]
        rows[arm] = {"nominal": mean_error(robot, one, others, "paper")[0]}
        for method in ("paper", "auto"):
            alone = mean_error(robot, one, others, method)[1:]
            each = [
                mean_error(robot, [p for p in every if p is not left], [left], method)[
                    1:
                ]
                for left in every
            ]
            rows[arm][method] = [
                *alone,
                *(fmean(column) for column in zip(*each, strict=True)),
            ]
        rows[arm]["floor"] = fmean(mean_error(robot, [p], [], "auto")[2] for p in every)
        print(arm, rows[arm], flush=True)
    return rows


def command(name: str, folders: Mapping[str, Path]) -> str:
    """Return what another benchmark prints."""
    words = COMMANDS[name].format(**folders).split()
    done = subprocess.run(
        [sys.executable, str(ROOT / "benchmarks" / words[0]), *words[1:]],
        check=True, capture_output=True, text=True,
    )  # fmt: skip
    # The table; no case by itself.
    begin = {"trust": "kind ", "costs": "| "}.get(name, "")
    return done.stdout[done.stdout.find(begin) :].rstrip()


def instrument(figures: Mapping[str, Any]) -> tuple[str, str, str, str]:
    """Return mean errors against the instrument as pages have them, in mm.

    They are by the nominal model, with the reflector refitted, by the URDF, and calibrated.
    """
    mean = next(
        r for r in figures["instrument"]["found"].splitlines() if r.startswith("mean:")
    )
    nominal, refitted, urdf, full = map(float, mean.split()[1:5])
    return f"{nominal:.2f}", f"{refitted:.2f}", f"{urdf:.3f}", f"{full:.3f}"


def table_rows(rows: Mapping[str, Any]) -> list[str]:
    """Return the rows of the accuracy table, as they stand in all pages that have it."""
    lines: list[str] = []
    for arm, row in rows.items():
        paper, auto = row["paper"], row["auto"]
        cells = [
            f"{row['nominal']:.3f}",
            f"{paper[0]:.3f} ({paper[2]:.3f})",
            f"{auto[0]:.3f} ({auto[2]:.3f})",
            f"{auto[1]:.3f} ({auto[3]:.3f})",
            f"{row['floor']:.3f}",
        ]
        lines.append(f"| {arm} | {' | '.join(cells)} |")
    return lines


def picture(rows: Mapping[str, Any]) -> bytes:
    """Return the errors of each arm at places held out, by each model."""
    kinds: dict[str, Callable[[Any], float]] = {
        "nominal": lambda row: row["nominal"],
        "paper": lambda row: row["paper"][0],
        "urdf": lambda row: row["auto"][0],
        "full": lambda row: row["auto"][1],
    }
    values = {kind: [of(row) for row in rows.values()] for kind, of in kinds.items()}
    axis = Axis.logarithmic(
        [v for each in values.values() for v in each], "mm, mean absolute error"
    )
    title = "held out: ball refitted (red), paper (violet), URDF (blue), joints corrected (green)"
    panel = named_rows(title, list(rows), axis, pitch=36, width=560)
    panel.bars(values["nominal"], values["full"], "link")
    for kind, each in values.items():
        panel.dots(each, kind, kind, size=6)
    return panel.file(STYLE)


TEXT = {
    "accuracy": """## Accuracy

Mean absolute error in mm at placements held out, on the recordings behind the paper's Table I:
trained on one placement, and in brackets on all but the one measured. The nominal model has the
place of its ball fitted. The floor is what is left in a placement that is fitted alone.

![Errors of each arm by each model](images/benchmarks.svg)

| arm | nominal | `paper` | `auto`, its URDF alone | `auto`, joints corrected | floor |
|---|---|---|---|---|---|
""",
    "instrument": """## Against an instrument

Points of a UR5 under a laser tracker, held out.
""",
    "arms": """## Four arms under instruments

Mean error in mm at points held out: by the nominal model with its reflector refitted, by the
calibrated URDF alone, and by the full model. The last columns are the points within the stated 68 %
and 95 %, in %.
""",
    "speed": """## Speed

A calibration's cost, as ratios against baselines in the same run.
""",
    "trust": """## Trust

Simulated and real recordings with one known mistake each: how many were stopped, and whether the
cause named first was right.
""",
    "costs": """## Costs of the exported C functions

Least of five runs in CPU time, beside Pinocchio's forward kinematics of the URDF in the same run.
""",
    "faults": """## Bad input

Recordings with something spoilt, and what `mukca solve` says; then bad files, and what other verbs
say. None may pass, and none may end in a traceback.
""",
    "growth": """## Growth

What `mukca solve` takes with more and more placements of 12 + 12 samples, and with more and more
samples in one placement. More than 40 placements are inspected in groups.
From 6,000 samples on, each takes 21 kB. Its derivatives by the 97 unknowns of a Panda with
elasticity and transmission error take 2.3 kB, and a fit holds several such arrays at once.
""",
}


def page(figures: Mapping[str, Any]) -> str:
    """Return the page."""
    parts = [
        "# Benchmarks\n\nWritten by `benchmarks/page.py`, which says how to measure again.\n"
    ]
    for name, text in TEXT.items():
        if name not in figures:
            continue
        kept = figures[name]
        if name == "accuracy":
            body = "\n".join(table_rows(kept["found"])) + "\n"
        else:
            words = COMMANDS[name].format(tracker="TRACKER")
            found = (
                kept["found"]
                if kept["found"].startswith("|")
                else f"```\n{kept['found']}\n```"
            )
            body = f"\n`python benchmarks/{words}` prints:\n\n{found}\n"
        parts.append(f"{text}{body}\nMeasured on {kept['date']}, {kept['machine']}.\n")
    return "\n".join([*parts, BY_HAND.read_text()])


def machine() -> str:
    """Return the processor and the programs that measured."""
    try:
        words = (
            Path("/proc/cpuinfo")
            .read_text()
            .partition("model name")[2]
            .partition(":")[2]
        )
        processor = words.partition("\n")[0].strip()
    except OSError:
        processor = platform.processor()
    return (
        f"{processor or 'unknown processor'}, {os.cpu_count()} cores, "
        f"Python {platform.python_version()}, mukca {mukca.__version__}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--measure", nargs="+", choices=list(TEXT), default=[])
    parser.add_argument(
        "--recordings", type=Path, default=ROOT.parent / "shared" / "recordings"
    )
    parser.add_argument(
        "--tracker", type=Path, default=ROOT.parent / "shared" / "tracker"
    )
    arguments = parser.parse_args()
    figures = json.loads(FIGURES.read_text()) if FIGURES.exists() else {}
    for name in arguments.measure:
        folders = vars(arguments)
        found = accuracy(folders) if name == "accuracy" else command(name, folders)
        figures[name] = {
            "date": str(date.today()),
            "machine": machine(),
            "found": found,
        }
        FIGURES.write_text(json.dumps(figures, indent=1) + "\n")
    PAGE.write_text(page(figures))
    PICTURE.write_bytes(picture(figures["accuracy"]["found"]))


if __name__ == "__main__":
    main()
