"""A verb on the calibration of one robot, or on that of each of several."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from ...solver import assessment, calibration
from ...solver.calibration import UsageError
from .console import Terminal
from .robots import split_by_robot


class _Kept(Terminal):
    """Keeps the JSON of each robot, to be written as one object."""

    def __init__(self, terminal: Terminal) -> None:
        super().__init__(json=terminal.json, brief=terminal.brief)
        self.robots: dict[str, Any] = {}
        self.name = ""

    def emit(self, value: Any) -> None:
        """Keep an object by the robot's name."""
        self.robots[self.name] = value if isinstance(value, dict) else value.as_dict()


def one_arm(file: Path) -> Path:
    """Return the ``calibration.json`` of a single robot; several are a UsageError."""
    files = calibration.calibration_files(file)
    if "" not in files:
        each = ", ".join(str(path.parent) for path in files.values())
        raise UsageError(f"{file}: holds several robots; name one of {each}")
    return files[""]


def for_each_arm(options: Any, terminal: Terminal, run: Callable[[Any, Terminal], int]) -> int:
    """Run a verb, and return its exit status; of several robots the worst.

    Each has placements of its own, ``NAME:PATH``, and writes what is named after it.
    """
    files = calibration.calibration_files(options.calibration)
    if "" in files:
        return run(replace(options, calibration=files[""]), terminal)
    kept, statuses, out = _Kept(terminal), list[int](), getattr(options, "out", None)
    data = split_by_robot(options.data, (), files)[0] if hasattr(options, "data") else None
    for kept.name, file in files.items():
        own: dict[str, Any] = {"calibration": file}
        if out is not None:
            file_out = out.with_name(f"{out.stem}_{kept.name}{out.suffix}")
            own["out"] = file_out if out.suffix else out / kept.name
        if data is not None:
            own["data"] = data[kept.name]
        if data is None or own["data"]:
            terminal.say(f"Robot {kept.name}")
            statuses.append(run(replace(options, **own), kept))
    terminal.emit({"robots": kept.robots})
    return assessment.worst(statuses)
